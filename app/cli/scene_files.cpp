#include "app/cli/scene_files.h"

#include "app/cli/child_processes.h"

namespace tandem {

std::filesystem::path SceneFile(const std::string& name_or_path) {
  const std::filesystem::path path = name_or_path;
  if (std::filesystem::exists(path) || path.has_parent_path() || path.has_extension()) return path;
  // build/bin/tandem reads build/scenes
  return ProgramFolder().parent_path() / "scenes" / (name_or_path + ".json");
}

}  // namespace tandem
