#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/base/files/block_file.h"
#include "engine/base/result.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/map/page_source.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// A voxmap in a file of a cache, compressed, with a record of its sources. It is read as a whole,
/// or hyperchunk by hyperchunk (paper §5.3):
///
///   pages   | per hyperchunk with planes, in Morton order, two pieces: its planes and the quarters
///           |   that no page before it has; the quarters that some page before it has
///   outline | where the pages are; index, chunk-level field and what is solid
///   tail    | the kind of the file, its sources, the place of the outline
///
/// The whole map takes the first pieces alone. Each page has its own checksum, so that no page is
/// read for the sake of another. The version grows by one when the same mesh and options come to
/// give other voxels or another file.
inline constexpr std::uint32_t kKeptVoxmapVersion = 3;

BlockFileSources KeyOf(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Voxelizes a mesh into a file, whole or not at all, and part by part where the options' memory
/// does not hold all of it. Returns nothing, or the error, which may be one of Voxelize().
std::optional<Error> KeepVoxmap(const TriangleMesh& mesh_W, const VoxelizeOptions& options,
                                const std::filesystem::path& file);
/// Writes a map to a file, likewise.
std::optional<Error> KeepVoxmap(const Voxmap& voxmap, const BlockFileSources& made_of,
                                const std::filesystem::path& file);
/// Reads a map from a file. Errors, in one line: a file that does not exist, has another kind or
/// version, is cut short or damaged, or is made of another mesh or with other options.
Result<Voxmap> LoadKeptVoxmap(const std::filesystem::path& file, const BlockFileSources& made_of);
/// Opens a map to be read page by page. Errors are the same but for those of its pages.
Result<std::shared_ptr<const PageSource>> OpenKeptVoxmap(const std::filesystem::path& file,
                                                         const BlockFileSources& made_of);
/// Returns what is wrong with a file, as far as that can be told without its mesh.
std::optional<Error> KeptVoxmapFault(const std::filesystem::path& file);

}  // namespace tandem
