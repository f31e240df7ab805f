#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/block_file.h"
#include "engine/base/result.h"
#include "engine/voxel/voxelize.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// Writes a map's image to a file, whole or not at all: a name beside it is written and then moved
/// there. Nothing, or what went wrong.
std::optional<Error> SaveVoxmap(const Voxmap& voxmap, const std::filesystem::path& file);

/// Maps an image from a file, read-only; its pages are read as they are first used. Refused in one
/// line: a file that is not there, of another kind or version, cut short, or whose index and
/// records point outside it.
Result<Voxmap> MapVoxmap(const std::filesystem::path& file);

/// A map in a file that says of what it was made (block_file.h), for a cache. The version grows by
/// one when the same mesh and options come to other voxels or to another image.
inline constexpr BlockFileKind kKeptVoxmapFile{
    {'t', 'a', 'n', 'd', 'e', 'm', 'K', 'V'}, 1, "voxmap of a cache"};

MadeOf KeyOf(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Writes a mesh's map to a file, whole or not at all. Nothing, or what went wrong.
std::optional<Error> KeepVoxmap(const Voxmap& voxmap, const TriangleMesh& mesh_W,
                                const VoxelizeOptions& options, const std::filesystem::path& file);
/// Maps a mesh's map from a file. Refused in one line: what MapBlocks() and MapVoxmap() refuse, and
/// a map of another mesh or with other options.
Result<Voxmap> MapKeptVoxmap(const std::filesystem::path& file, const TriangleMesh& mesh_W,
                             const VoxelizeOptions& options);
/// Tells what is wrong with a file, as far as that can be told without its mesh.
std::optional<Error> KeptVoxmapFault(const std::filesystem::path& file);

}  // namespace tandem
