#include "app/program_folders.h"

#include <cstdlib>

namespace tandem {

std::filesystem::path ProgramFolder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

std::filesystem::path SceneFolder() {
  const std::filesystem::path above = ProgramFolder().parent_path();
  const std::filesystem::path installed = above / "share/tandem/scenes";
  std::error_code unknown;
  return std::filesystem::is_directory(installed, unknown) ? installed : above / "scenes";
}

std::filesystem::path PersonsFolder(const char* variable, const std::filesystem::path& below_home) {
  // nothing of ours sets the environment
  const auto named = [](const char* name) {
    const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
    return std::filesystem::path(value != nullptr ? value : "");
  };
  std::filesystem::path folder = named(variable);
  if (folder.empty() || folder.is_relative()) {
    const std::filesystem::path home = named("HOME");
    if (home.empty()) return {};
    folder = home / below_home;
  }
  return folder / "tandem";
}

}  // namespace tandem
