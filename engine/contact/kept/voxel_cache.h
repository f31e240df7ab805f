#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "engine/contact/kept/surface_file.h"
#include "engine/geometry/import/kept_mesh.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/map/page_source.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

/// A file of a cache.
struct CachedFile {
  std::filesystem::path file;
  std::uint64_t bytes = 0;
  std::filesystem::file_time_type used;  // time of the last use
};

/// Keeps what is made of mesh files in a folder that is the user's alone: meshes as read, surfaces
/// of refined contact, voxmaps and points of plain contact. Programs share it: what a program makes
/// of a mesh the next program maps. A file's name is derived from its sources, so that no program
/// asks for a stale file. A file that is cut short or damaged is replaced. Where a file cannot be
/// written, its content is made anew each time. Any number of threads and programs may use a folder
/// at once.
class VoxelCache {
 public:
  /// Files smaller than this are not kept: making them takes no time.
  static constexpr std::uint64_t kLeastBytes = 256 << 10U;
  static constexpr std::uint64_t kMostBytes = std::uint64_t{10} << 30U;

  /// `most_bytes`: bound of all files together; the least recently used files go first.
  explicit VoxelCache(std::filesystem::path folder, std::uint64_t most_bytes = kMostBytes);

  const std::filesystem::path& folder() const noexcept { return folder_; }
  std::uint64_t most_bytes() const noexcept { return most_bytes_; }

  /// Returns what ImportAndDiagnose() reads from a file, with the same errors: from a file of the
  /// cache if that file's bytes are known. Meshes are kept only for kinds of files that name no
  /// others.
  Result<ImportedMesh> MeshOf(const std::filesystem::path& file,
                              const ImportOptions& options) const;

  /// Returns the points that MakePointshell() makes of a mesh, with the same errors. It reads them
  /// from their file, or makes and keeps them.
  Result<Pointshell> PointsOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                              const PointshellOptions& options) const;

  /// Returns the surface that BuildSurface() makes of a mesh, with the same errors, likewise.
  Result<BodySurface> SurfaceOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                                const SurfaceOptions& options) const;

  /// Returns the voxmap that Voxelize() makes of a mesh, with the same errors, likewise.
  Result<Voxmap> VoxmapOf(const TriangleMesh& mesh_W, const VoxelizeOptions& options) const;

  /// Returns the same voxmap to be read page by page: from its file, which is made first where
  /// there is none. Pages are checked as they are read.
  Result<std::shared_ptr<const PageSource>> PagesOf(const TriangleMesh& mesh_W,
                                                    const VoxelizeOptions& options) const;

  /// Returns all files, the most recently used first.
  std::vector<CachedFile> Files() const;
  /// Returns what is wrong with a file of Files(), without its mesh.
  static std::optional<Error> FaultOf(const std::filesystem::path& file);
  /// Removes all files and returns their number.
  std::size_t Clear() const;

 private:
  std::filesystem::path FileOf(const BlockFileSources& key, unsigned version,
                               const char* ending) const;
  bool MayRead(const std::filesystem::path& file) const;
  void Keep(const std::filesystem::path& file,
            const std::function<std::optional<Error>()>& save) const;
  void RemoveOldest() const;

  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
};

}  // namespace tandem
