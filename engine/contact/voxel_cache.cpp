#include "engine/contact/surface_cache.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".surface";

/// Tells whether a file is the user's own and nobody else may write to it.
bool IsOwn(const fs::path& file) {
  struct stat status {};
  if (lstat(file.c_str(), &status) != 0) return false;
  return S_ISREG(status.st_mode) && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

}  // namespace

SurfaceCache::SurfaceCache(fs::path folder, std::uint64_t most_bytes)
    : folder_(std::move(folder)), most_bytes_(most_bytes) {}

fs::path SurfaceCache::FileOf(const SurfaceKey& key) const {
  char name[64];
  std::snprintf(name, sizeof name, "%016" PRIx64 "-%016" PRIx64 "-v%u%s", key.mesh, key.settings,
                kSurfaceVersion, kEnding);
  return folder_ / name;
}

Result<BodySurface> SurfaceCache::SurfaceOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                                            const SurfaceOptions& options) const {
  const fs::path file = FileOf(KeyOf(mesh_W, options));
  if (IsOwn(file)) {
    Result<BodySurface> mapped = MapSurface(file, mesh_W, X_WB, options);
    if (mapped) {
      std::error_code read_only;  // then its use is not noted
      fs::last_write_time(file, fs::file_time_type::clock::now(), read_only);
      return mapped;
    }
  }
  Result<BodySurface> made = BuildSurface(mesh_W, X_WB, options);
  if (!made) return made;
  if (made->field.bytes().size() + made->features.bytes().size() >= kLeastBytes) {
    Keep(*made, mesh_W, options, file);
  }
  return made;
}

void SurfaceCache::Keep(const BodySurface& surface, const TriangleMesh& mesh_W,
                        const SurfaceOptions& options, const fs::path& file) const {
  std::error_code failed;
  if (!folder_.parent_path().empty()) fs::create_directories(folder_.parent_path(), failed);
  if (mkdir(folder_.c_str(), 0700) != 0 && !fs::is_directory(folder_, failed)) return;
  // what stands in its place is damaged, or another's
  fs::remove(file, failed);
  if (SaveSurface(surface, mesh_W, options, file)) return;
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write, failed);
  RemoveOldest();
}

std::vector<CachedSurface> SurfaceCache::Files() const {
  std::vector<CachedSurface> files;
  std::error_code failed;
  for (fs::directory_iterator at(folder_, failed), end; !failed && at != end;
       at.increment(failed)) {
    // others may remove files meanwhile
    std::error_code gone;
    if (at->path().extension() != kEnding || !at->is_regular_file(gone)) continue;
    CachedSurface file{.file = at->path(), .bytes = at->file_size(gone), .used = {}};
    if (!gone) file.used = at->last_write_time(gone);
    if (!gone) files.push_back(std::move(file));
  }
  std::sort(files.begin(), files.end(), [](const CachedSurface& a, const CachedSurface& b) {
    return a.used != b.used ? a.used > b.used : a.file < b.file;
  });
  return files;
}

void SurfaceCache::RemoveOldest() const {
  std::uint64_t bytes = 0;
  for (const CachedSurface& file : Files()) {
    bytes += file.bytes;
    std::error_code gone;
    if (bytes > most_bytes_) fs::remove(file.file, gone);
  }
}

std::size_t SurfaceCache::Clear() const {
  std::size_t count = 0;
  for (const CachedSurface& file : Files()) {
    std::error_code gone;
    count += fs::remove(file.file, gone) ? 1 : 0;
  }
  return count;
}

}  // namespace tandem
