#include "app/connection/scene_search.h"

#include <algorithm>
#include <string>

#include "app/common/program_folders.h"
#include "app/connection/state_lines.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/files/sha256.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_hash.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFoldersList = "scene_folders";
constexpr std::size_t kMostRemembered = 8;    // folders
constexpr std::size_t kMostFiles = 500;       // files of a folder
constexpr std::uintmax_t kLargest = 1 << 22;  // bytes of a scene file; larger files hold other
                                              // things

constexpr std::uintmax_t kLargestCertificate = 1 << 16;

void AddOnce(std::vector<fs::path>& folders, const fs::path& folder) {
  std::error_code unknown;
  const bool known = std::any_of(folders.begin(), folders.end(), [&](const fs::path& one) {
    return fs::equivalent(one, folder, unknown);
  });
  if (!known && fs::is_directory(folder, unknown)) folders.push_back(folder);
}

std::vector<fs::path> SceneFilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code unreadable;
  for (fs::directory_iterator entry(folder, unreadable), end; !unreadable && entry != end;
       entry.increment(unreadable)) {
    if (!MayBeSceneFile(entry->path())) continue;
    files.push_back(entry->path());
    if (files.size() == kMostFiles) break;
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool Is(const fs::path& file, const WantedScene& wanted) {
  const Result<Scene> scene = LoadScene(file);
  if (!scene) return false;
  if (wanted.bodies != 0 && scene->bodies.size() != wanted.bodies) return false;
  const Result<SceneHash> hash = HashScene(*scene);
  if (!hash) return false;
  return wanted.digest ? hash->digest == *wanted.digest : hash->content == wanted.content_hash;
}

}  // namespace

WantedScene WantedFrom(const SceneManifest& manifest, const fs::path& keys) {
  return {.digest = manifest.content_digest,
          .content_hash = manifest.content_hash,
          .file = manifest.file,
          .bodies = manifest.bodies.size(),
          .open_told = false,
          .fetched = FetchedScenes(keys)};
}

std::vector<fs::path> FoldersWithScenes() {
  std::vector<fs::path> folders;
  std::error_code unknown;
  AddOnce(folders, fs::current_path(unknown));
  for (const fs::path& folder : StateLines(kFoldersList, kMostRemembered)) AddOnce(folders, folder);
  AddOnce(folders, SceneFolder());
  return folders;
}

std::optional<SceneStore> FetchedScenes(const fs::path& keys) {
  const fs::path cache = CacheFolder();
  if (cache.empty()) return std::nullopt;
  std::error_code failed;
  const fs::path folder = fs::absolute(cache, failed) / "fetched";
  if (failed) return std::nullopt;
  if (keys.empty()) return SceneStore(folder);
  RunningSha256 authority;
  for (const char* file : {"identity_ca.pem", "permissions_ca.pem"}) {
    const Result<std::string> certificate = ReadWholeFile(keys / file, kLargestCertificate);
    if (!certificate) return std::nullopt;
    authority.AddText(*certificate);
  }
  return SceneStore(folder, authority.Value());
}

bool MayBeSceneFile(const fs::path& file) {
  std::error_code unknown;
  if (file.extension() != ".json" || !fs::is_regular_file(file, unknown)) return false;
  return fs::file_size(file, unknown) <= kLargest && !unknown;
}

std::optional<fs::path> FindScene(const WantedScene& wanted, const std::vector<fs::path>& folders,
                                  const std::stop_token& stop) {
  if (wanted.open_told && MayBeSceneFile(wanted.file) && Is(wanted.file, wanted)) {
    return wanted.file;
  }
  if (wanted.fetched && wanted.digest) {
    const fs::path file = wanted.fetched->SceneFileOf(*wanted.digest);
    if (MayBeSceneFile(file) && Is(file, wanted)) {
      wanted.fetched->Touch(*wanted.digest);
      return file;
    }
  }
  std::vector<fs::path> files;
  for (const fs::path& folder : folders) {
    const std::vector<fs::path> some = SceneFilesIn(folder);
    files.insert(files.end(), some.begin(), some.end());
  }
  std::stable_partition(files.begin(), files.end(), [&](const fs::path& file) {
    return file.filename() == wanted.file.filename();
  });
  const auto found = std::find_if(files.begin(), files.end(), [&](const fs::path& file) {
    return stop.stop_requested() || Is(file, wanted);
  });
  return found == files.end() || stop.stop_requested() ? std::nullopt : std::optional(*found);
}

void RememberSceneFolder(const fs::path& scene) {
  std::error_code failed;
  const fs::path folder = fs::absolute(scene, failed).lexically_normal().parent_path();
  std::error_code unknown;
  if (failed || fs::equivalent(folder, SceneFolder(), unknown)) return;  // always searched
  PutFirst(kFoldersList, folder, kMostRemembered);
}

}  // namespace tandem
