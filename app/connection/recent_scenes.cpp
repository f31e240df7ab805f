#include "app/connection/recent_scenes.h"

#include "app/connection/state_lines.h"

namespace tandem {

namespace {
constexpr std::size_t kMostScenes = 10;
constexpr const char* kScenesList = "recent_scenes";
}  // namespace

std::vector<std::filesystem::path> RecentScenes() {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& file : StateLines(kScenesList, kMostScenes)) {
    std::error_code unknown;
    if (std::filesystem::is_regular_file(file, unknown)) files.push_back(file);
  }
  return files;
}

void RememberScene(const std::filesystem::path& file) {
  std::error_code failed;
  const std::filesystem::path whole = std::filesystem::absolute(file, failed).lexically_normal();
  if (!failed) PutFirst(kScenesList, whole, kMostScenes);
}

}  // namespace tandem
