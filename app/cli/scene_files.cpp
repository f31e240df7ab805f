#include "app/cli/scene_files.h"

#include "app/cli/child_processes.h"

namespace tandem {

std::filesystem::path SceneFile(const std::string& name_or_path) {
  if (std::filesystem::exists(name_or_path)) return name_or_path;
  // build/bin/tandem reads build/scenes
  return ProgramFolder().parent_path() / "scenes" / (name_or_path + ".json");
}

}  // namespace tandem
