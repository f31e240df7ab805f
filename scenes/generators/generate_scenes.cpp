#include <cstdio>

#include "scenes/generators/generated_scene.h"
#include "scenes/generators/generator_command.h"

// generate_scenes FOLDER: writes the files that the scene files in FOLDER name.
int main(int argc, char** argv) {
  int exit_code = 0;
  const auto folder =
      tandem::FolderToFill(argc, argv, "generate_scenes",
                           "writes the files that the scene files in FOLDER name", exit_code);
  if (!folder) return exit_code;
  for (const tandem::GeneratedScene& scene : tandem::GeneratedScenes()) {
    if (const auto fault = tandem::WriteScene(scene, *folder)) {
      std::fprintf(stderr, "%s\n", fault->what.c_str());
      return 1;
    }
  }
  const std::filesystem::path stability = *folder / "stability";
  if (const auto fault = tandem::WriteScene(tandem::StabilityParts(), stability)) {
    std::fprintf(stderr, "%s\n", fault->what.c_str());
    return 1;
  }
  return 0;
}
