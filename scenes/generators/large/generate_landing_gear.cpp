#include <cstdio>

#include "scenes/generators/generator_command.h"
#include "scenes/generators/large/clutter.h"
#include "scenes/generators/large/landing_gear.h"

// generate_landing_gear FOLDER: writes the files that landing_gear.json in FOLDER names.
int main(int argc, char** argv) {
  int exit_code = 0;
  const auto folder =
      tandem::FolderToFill(argc, argv, "generate_landing_gear",
                           "writes the files that landing_gear.json in FOLDER names", exit_code);
  if (!folder) return exit_code;
  const std::vector<tandem::TriangleMesh> parts =
      tandem::MakeLandingGear(tandem::LandingGearParts::kAll);
  const tandem::GeneratedScene scene = tandem::LandingGear(parts);
  tandem::PrintSizes(parts, scene);
  if (const auto fault = tandem::WriteScene(scene, *folder)) {
    std::fprintf(stderr, "%s\n", fault->what.c_str());
    return 1;
  }
  return 0;
}
