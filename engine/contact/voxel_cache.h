#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "engine/contact/surface_file.h"

namespace tandem {

/// A file of a cache.
struct CachedSurface {
  std::filesystem::path file;
  std::uint64_t bytes = 0;
  std::filesystem::file_time_type used;  // last
};

/// Surfaces in files of a folder that is the user's alone. Programs share it: what one has made of
/// a mesh the next one maps. A file's name says of what it was made, so that what is stale is never
/// asked for; a file that is cut short or damaged is replaced. Where a file cannot be written, the
/// surface is made anew each time. Any number of threads and programs may use a folder at once.
class SurfaceCache {
 public:
  /// Files smaller than this are not kept: making such a surface takes no time.
  static constexpr std::uint64_t kLeastBytes = 256 << 10U;
  static constexpr std::uint64_t kMostBytes = std::uint64_t{10} << 30U;

  /// `most_bytes`: of all files together; those whose last use is longest ago go first.
  explicit SurfaceCache(std::filesystem::path folder, std::uint64_t most_bytes = kMostBytes);

  const std::filesystem::path& folder() const noexcept { return folder_; }
  std::uint64_t most_bytes() const noexcept { return most_bytes_; }

  /// The surface that BuildSurface() makes of a mesh, with the same errors: from its file, or made
  /// and kept.
  Result<BodySurface> SurfaceOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                                const SurfaceOptions& options) const;

  /// All files, the last used first.
  std::vector<CachedSurface> Files() const;
  /// Removes all files, and tells how many.
  std::size_t Clear() const;

 private:
  std::filesystem::path FileOf(const SurfaceKey& key) const;
  void Keep(const BodySurface& surface, const TriangleMesh& mesh_W, const SurfaceOptions& options,
            const std::filesystem::path& file) const;
  void RemoveOldest() const;

  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
};

}  // namespace tandem
