#include <cstdio>

#include "scenes/generators/large/clutter.h"
#include "scenes/generators/large/landing_gear.h"

// generate_landing_gear FOLDER: writes the files that landing_gear.json in FOLDER names.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: generate_landing_gear FOLDER\n");
    return 2;
  }
  const std::vector<tandem::TriangleMesh> parts =
      tandem::MakeLandingGear(tandem::LandingGearParts::kAll);
  const tandem::GeneratedScene scene = tandem::LandingGear(parts);
  tandem::PrintSizes(parts, scene);
  if (const auto fault = tandem::WriteScene(scene, argv[1])) {
    std::fprintf(stderr, "%s\n", fault->what.c_str());
    return 1;
  }
  return 0;
}
