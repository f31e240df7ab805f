#include "app/reach/scene_search.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include <unistd.h>

#include "app/program_folders.h"
#include "engine/world/scene.h"
#include "engine/world/scene_hash.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostRemembered = 8;    // folders
constexpr std::size_t kMostFiles = 500;       // of a folder
constexpr std::uintmax_t kLargest = 1 << 22;  // bytes of a scene file; others hold other things

// Nothing of ours sets the environment.
std::string Environment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr ? value : "";
}

/// Empty: there is no place for it.
fs::path StateFile() {
  fs::path folder = Environment("XDG_STATE_HOME");
  if (folder.empty() || folder.is_relative()) {
    const fs::path home = Environment("HOME");
    if (home.empty()) return {};
    folder = home / ".local" / "state";
  }
  return folder / "tandem" / "scene_folders";
}

std::vector<fs::path> Remembered() {
  std::vector<fs::path> folders;
  std::ifstream stream(StateFile());
  for (std::string line; folders.size() < kMostRemembered && std::getline(stream, line);) {
    if (!line.empty()) folders.emplace_back(line);
  }
  return folders;
}

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
  return hash && hash->content == wanted.content_hash;
}

}  // namespace

WantedScene WantedFrom(const SceneManifest& manifest) {
  return {manifest.content_hash, manifest.file, manifest.bodies.size()};
}

std::vector<fs::path> FoldersWithScenes() {
  std::vector<fs::path> folders;
  std::error_code unknown;
  AddOnce(folders, fs::current_path(unknown));
  for (const fs::path& folder : Remembered()) AddOnce(folders, folder);
  AddOnce(folders, SceneFolder());
  return folders;
}

bool MayBeSceneFile(const fs::path& file) {
  std::error_code unknown;
  if (file.extension() != ".json" || !fs::is_regular_file(file, unknown)) return false;
  return fs::file_size(file, unknown) <= kLargest && !unknown;
}

std::optional<fs::path> FindScene(const WantedScene& wanted, const std::vector<fs::path>& folders,
                                  const std::stop_token& stop) {
  if (MayBeSceneFile(wanted.file) && Is(wanted.file, wanted)) return wanted.file;
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
  if (failed || folder.string().find('\n') != std::string::npos) return;
  std::error_code unknown;
  if (fs::equivalent(folder, SceneFolder(), unknown)) return;  // always looked in
  std::vector<fs::path> folders = Remembered();
  if (!folders.empty() && folders.front() == folder) return;
  std::erase(folders, folder);
  folders.insert(folders.begin(), folder);
  folders.resize(std::min(folders.size(), kMostRemembered));
  const fs::path file = StateFile();
  if (file.empty()) return;
  fs::create_directories(file.parent_path(), failed);
  if (failed) return;
  // whole or not at all, whoever else does the same
  const fs::path written = file.string() + "." + std::to_string(getpid());
  std::ofstream stream(written);
  for (const fs::path& one : folders) stream << one.string() << '\n';
  if (stream.flush()) {
    fs::rename(written, file, failed);
  } else {
    fs::remove(written, failed);
  }
}

}  // namespace tandem
