#include <cstdio>

#include "scenes/clutter.h"

// generate_clutter FOLDER: writes what clutter.json in FOLDER names, and the poses of both scenes
// that are compared with other engines.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: generate_clutter FOLDER\n");
    return 2;
  }
  const tandem::ClutterShape shape;
  const std::vector<tandem::TriangleMesh> parts = tandem::ClutterParts(shape);
  tandem::GeneratedScene scene = tandem::Clutter(parts);
  const tandem::TriangleMesh& fixed = scene.meshes[0].mesh;
  const tandem::Vec3 size = tandem::BoundsOf(fixed).size();
  std::printf(
      "clutter: %zu parts, %zu triangles, %.2f x %.2f x %.2f m, %.1f m^2; actuator: %zu "
      "triangles, %.3f m^2\n",
      parts.size(), fixed.triangles.size(), 1e-3 * size.x(), 1e-3 * size.y(), 1e-3 * size.z(),
      1e-6 * tandem::AreaOf(fixed), scene.meshes[1].mesh.triangles.size(),
      1e-6 * tandem::AreaOf(scene.meshes[1].mesh));
  std::printf("vertices inside another part: %.4f %%\n", 100 * tandem::OverlapShare(parts));
  if (const auto fault = tandem::WriteScene(scene, argv[1])) {
    std::fprintf(stderr, "%s\n", fault->what.c_str());
    return 1;
  }
  return 0;
}
