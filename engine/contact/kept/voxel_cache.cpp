#include "engine/contact/kept/voxel_cache.h"

#include <algorithm>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

#include "engine/base/files/unfinished.h"
#include "engine/base/text/hex.h"
#include "engine/voxel/pages/computed_pages.h"
#include "engine/voxel/pages/kept_voxmap.h"
#include "engine/voxel/points/kept_points.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr const char* kSurfaceEnding = ".surface";
constexpr const char* kVoxmapEnding = ".voxmap";
constexpr const char* kMeshEnding = ".mesh";
constexpr const char* kPointsEnding = ".points";

/// Tells whether a file is the user's own and nobody else may write to it.
bool IsOwn(const fs::path& file) {
  struct stat status {};
  if (lstat(file.c_str(), &status) != 0) return false;
  return S_ISREG(status.st_mode) && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Tells whether a folder is the user's own and nobody else may put anything into it.
bool IsOwnFolder(const fs::path& folder) {
  struct stat status {};
  if (stat(folder.c_str(), &status) != 0) return false;
  return S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Notes the use of a file that could be mapped, and passes on `mapped`.
template <typename Content>
Result<Content> Noted(Result<Content> mapped, const fs::path& file) {
  std::error_code read_only;  // the error of a read-only file, whose use is not noted
  if (mapped) fs::last_write_time(file, fs::file_time_type::clock::now(), read_only);
  return mapped;
}

}  // namespace

VoxelCache::VoxelCache(fs::path folder, std::uint64_t most_bytes)
    : folder_(std::move(folder)), most_bytes_(most_bytes) {}

fs::path VoxelCache::FileOf(const BlockFileSources& key, unsigned version,
                            const char* ending) const {
  // half of each digest, because some file systems take names of 143 bytes at most; the file has
  // all
  const auto half = [](const Sha256& digest) {
    return HexOfBytes(std::span(digest).first(digest.size() / 2));
  };
  return folder_ /
         (half(key.mesh) + "-" + half(key.settings) + "-v" + std::to_string(version) + ending);
}

bool VoxelCache::MayRead(const fs::path& file) const {
  return IsOwnFolder(folder_) && IsOwn(file);
}

Result<ImportedMesh> VoxelCache::MeshOf(const fs::path& file, const ImportOptions& options) const {
  const std::optional<BlockFileSources> key = KeyOf(file, options);
  if (!key) return ImportAndDiagnose(file, options);
  const fs::path kept = FileOf(*key, kKeptMeshFile.version, kMeshEnding);
  if (MayRead(kept)) {
    if (auto loaded = Noted(LoadKeptMesh(kept, *key), kept)) return loaded;
  }
  Result<ImportedMesh> made = ImportAndDiagnose(file, options);
  if (!made) return made;
  if (made->mesh.triangles.size() * sizeof(TriangleMesh::Triangle) >= kLeastBytes) {
    Keep(kept, [&] {
      return KeepMesh(*made, *key, kept);
    });
  }
  return made;
}

Result<Pointshell> VoxelCache::PointsOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                                        const PointshellOptions& options) const {
  const BlockFileSources key = KeyOf(mesh_W, X_WB, options);
  const fs::path file = FileOf(key, kKeptPointsFile.version, kPointsEnding);
  if (MayRead(file)) {
    if (auto loaded = Noted(LoadKeptPoints(file, key), file)) return loaded;
  }
  Result<Pointshell> made = MakePointshell(mesh_W, X_WB, options);
  if (!made) return made;
  if (made->size() * 6 * sizeof(float) >= kLeastBytes) {
    Keep(file, [&] {
      return KeepPoints(*made, key, file);
    });
  }
  return made;
}

Result<BodySurface> VoxelCache::SurfaceOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                                          const SurfaceOptions& options) const {
  const fs::path file = FileOf(KeyOf(mesh_W, options), kSurfaceFile.version, kSurfaceEnding);
  if (MayRead(file)) {
    if (auto mapped = Noted(MapSurface(file, mesh_W, X_WB, options), file)) return mapped;
  }
  Result<BodySurface> made = BuildSurface(mesh_W, X_WB, options);
  if (!made) return made;
  if (made->field.bytes().size() + made->features.bytes().size() >= kLeastBytes) {
    Keep(file, [&] {
      return SaveSurface(*made, mesh_W, options, file);
    });
  }
  return made;
}

Result<Voxmap> VoxelCache::VoxmapOf(const TriangleMesh& mesh_W,
                                    const VoxelizeOptions& options) const {
  const BlockFileSources key = KeyOf(mesh_W, options);
  const fs::path file = FileOf(key, kKeptVoxmapVersion, kVoxmapEnding);
  if (MayRead(file)) {
    if (auto loaded = Noted(LoadKeptVoxmap(file, key), file)) return loaded;
  }
  Result<Voxmap> made = Voxelize(mesh_W, options);
  if (!made) return made;
  if (made->header().bytes >= kLeastBytes) {
    Keep(file, [&] {
      return KeepVoxmap(*made, key, file);
    });
  }
  return made;
}

Result<std::shared_ptr<const PageSource>> VoxelCache::PagesOf(
    const TriangleMesh& mesh_W, const VoxelizeOptions& options) const {
  const BlockFileSources key = KeyOf(mesh_W, options);
  const fs::path file = FileOf(key, kKeptVoxmapVersion, kVoxmapEnding);
  if (MayRead(file)) {
    if (auto open = Noted(OpenKeptVoxmap(file, key), file)) return open;
  }
  std::optional<Error> fault;
  Keep(file, [&] {
    fault = KeepVoxmap(mesh_W, options, file);
    return fault;
  });
  if (fault) return *fault;
  if (MayRead(file)) return OpenKeptVoxmap(file, key);
  // the file could not be kept
  return ComputePages(mesh_W, options);
}

void VoxelCache::Keep(const fs::path& file,
                      const std::function<std::optional<Error>()>& save) const {
  std::error_code failed;
  if (!folder_.parent_path().empty()) fs::create_directories(folder_.parent_path(), failed);
  mkdir(folder_.c_str(), 0700);
  if (!IsOwnFolder(folder_)) return;
  // a file of the user's is replaced; a link, or a file that others may write to, goes first
  if (!IsOwn(file)) fs::remove(file, failed);
  if (save()) return;
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write, failed);
  RemoveOldest();
}

std::optional<Error> VoxelCache::FaultOf(const fs::path& file) {
  const fs::path ending = file.extension();
  if (ending == kSurfaceEnding) return SurfaceFault(file);
  if (ending == kMeshEnding) return KeptMeshFault(file);
  return ending == kPointsEnding ? KeptPointsFault(file) : KeptVoxmapFault(file);
}

std::vector<CachedFile> VoxelCache::Files() const {
  std::vector<CachedFile> files;
  std::error_code failed;
  for (fs::directory_iterator at(folder_, failed), end; !failed && at != end;
       at.increment(failed)) {
    // other programs may remove files meanwhile
    std::error_code gone;
    const fs::path ending = at->path().extension();
    if (ending != kSurfaceEnding && ending != kVoxmapEnding && ending != kMeshEnding &&
        ending != kPointsEnding) {
      continue;
    }
    if (!at->is_regular_file(gone)) continue;
    CachedFile file{.file = at->path(), .bytes = at->file_size(gone), .used = {}};
    if (!gone) file.used = at->last_write_time(gone);
    if (!gone) files.push_back(std::move(file));
  }
  std::sort(files.begin(), files.end(), [](const CachedFile& a, const CachedFile& b) {
    return a.used != b.used ? a.used > b.used : a.file < b.file;
  });
  return files;
}

void VoxelCache::RemoveOldest() const {
  // the newest stays, whatever its size: it is about to be used
  const std::vector<CachedFile> files = Files();
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    bytes += files[i].bytes;
    std::error_code gone;
    if (i > 0 && bytes > most_bytes_) fs::remove(files[i].file, gone);
  }
}

std::size_t VoxelCache::Clear() const {
  std::size_t count = 0;
  for (const CachedFile& file : Files()) {
    std::error_code gone;
    count += fs::remove(file.file, gone) ? 1 : 0;
  }
  // files that programs left when they were killed while they wrote
  std::error_code failed;
  std::vector<fs::path> places;
  for (fs::directory_iterator at(folder_, failed), end; !failed && at != end;
       at.increment(failed)) {
    const std::string name = at->path().filename().string();
    const std::size_t cut = name.find(".unfinished-");
    if (cut != std::string::npos) places.push_back(folder_ / name.substr(0, cut));
  }
  for (const fs::path& place : places) RemoveRemainders(place);
  return count;
}

}  // namespace tandem
