#include "app/program_folders.h"

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

}  // namespace tandem
