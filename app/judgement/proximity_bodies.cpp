#include "app/judgement/proximity_bodies.h"

#include "engine/geometry/import/mesh_file.h"

namespace tandem {

Result<std::vector<ProximityBody>> LoadProximityBodies(const Scene& scene,
                                                       std::vector<std::string>* remarks) {
  std::vector<ProximityBody> bodies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    std::vector<std::string> of_mesh;
    const Result<TriangleMesh> mesh_M =
        ImportMesh(body.mesh, {.scale = body.scale, .part = body.part}, &of_mesh);
    if (!mesh_M) return Error{"body '" + body.name + "': " + mesh_M.error().what};
    for (const std::string& remark : of_mesh) {
      if (remarks == nullptr) break;
      remarks->push_back("body '" + body.name + "' (" + body.mesh.string() + "): " + remark);
    }
    bodies.push_back({body.name, body.fixed, Transformed(*mesh_M, body.X_WM)});
    if (scene.WholeOf(i) != i) bodies.back().part_of = scene.WholeOf(i);
  }
  return bodies;
}

}  // namespace tandem
