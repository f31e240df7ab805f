#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/base/block_file.h"
#include "engine/base/result.h"
#include "engine/voxel/page_source.h"
#include "engine/voxel/voxelize.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// A voxmap in a file of a cache, compressed, which says of what it was made. It is read as a
/// whole, or hyperchunk by hyperchunk (paper §5.3):
///
///   pages   | per hyperchunk with planes, in Morton order, two pieces: its planes and the quarters
///           |   that no page before it has; the quarters that some page before it has
///   outline | where the pages are; index, chunk-level field and what is solid
///   tail    | what the file is, of what it was made, where the outline is
///
/// The whole map takes the first pieces alone. Each page has a checksum of its own, so that none is
/// read for the sake of the others. The version grows by one when the same mesh and options come to
/// other voxels or to another file.
inline constexpr std::uint32_t kKeptVoxmapVersion = 2;

MadeOf KeyOf(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Voxelizes a mesh into a file, part by part where the options' memory does not hold all of it,
/// and whole or not at all. Nothing, or what went wrong, as of Voxelize() too.
std::optional<Error> KeepVoxmap(const TriangleMesh& mesh_W, const VoxelizeOptions& options,
                                const std::filesystem::path& file);
/// Writes a map to a file likewise.
std::optional<Error> KeepVoxmap(const Voxmap& voxmap, const MadeOf& made_of,
                                const std::filesystem::path& file);
/// Reads a map from a file. Refused in one line: a file that is not there, of another kind or
/// version, cut short or damaged, made of another mesh or with other options.
Result<Voxmap> LoadKeptVoxmap(const std::filesystem::path& file, const MadeOf& made_of);
/// Opens a map to be read page by page, with the same refusals but those of its pages.
Result<std::shared_ptr<const PageSource>> OpenKeptVoxmap(const std::filesystem::path& file,
                                                         const MadeOf& made_of);
/// Tells what is wrong with a file, as far as that can be told without its mesh.
std::optional<Error> KeptVoxmapFault(const std::filesystem::path& file);

}  // namespace tandem
