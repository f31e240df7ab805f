#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/files/block_file.h"
#include "engine/base/result.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

/// A pointshell in a file of a cache. The version grows by one when the same mesh and options come
/// to give other points or other bytes.
inline constexpr BlockFileKind kKeptPointsFile{
    {'t', 'a', 'n', 'd', 'e', 'm', 'K', 'P'}, 2, "pointshell of a cache"};

BlockFileSources KeyOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                       const PointshellOptions& options);

/// Writes points to a file, whole or not at all. Returns nothing, or the error.
std::optional<Error> KeepPoints(const Pointshell& points, const BlockFileSources& made_of,
                                const std::filesystem::path& file);
/// Reads them again. Errors, in one line, are those of MapBlocks(), and points of another mesh or
/// with other options.
Result<Pointshell> LoadKeptPoints(const std::filesystem::path& file,
                                  const BlockFileSources& made_of);
/// Returns what is wrong with a file, as far as that can be told without its mesh.
std::optional<Error> KeptPointsFault(const std::filesystem::path& file);

}  // namespace tandem
