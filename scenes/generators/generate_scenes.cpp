#include <cstdio>

#include "scenes/generators/generated_scene.h"

// generate_scenes FOLDER: writes the files that the scene files in FOLDER name.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: generate_scenes FOLDER\n");
    return 2;
  }
  for (const tandem::GeneratedScene& scene : tandem::GeneratedScenes()) {
    if (const auto fault = tandem::WriteScene(scene, argv[1])) {
      std::fprintf(stderr, "%s\n", fault->what.c_str());
      return 1;
    }
  }
  const std::filesystem::path stability = std::filesystem::path(argv[1]) / "stability";
  if (const auto fault = tandem::WriteScene(tandem::StabilityParts(), stability)) {
    std::fprintf(stderr, "%s\n", fault->what.c_str());
    return 1;
  }
  return 0;
}
