#include "app/view/model/scene/drawn_scene.h"

namespace tandem {

Bounds DrawnScene::BoundsOfAll() const {
  Bounds all;
  for (const DrawnBody& body : bodies) {
    if (body.bounds_W.empty()) continue;
    all.Add(body.bounds_W.min);
    all.Add(body.bounds_W.max);
  }
  return all;
}

std::size_t DrawnScene::TriangleCount() const {
  std::size_t count = 0;
  for (const DrawnBody& body : bodies) count += body.mesh.triangles.size() / 3;
  return count;
}

std::size_t DrawnScene::FileTriangleCount() const {
  std::size_t count = 0;
  for (const DrawnBody& body : bodies) count += body.file_triangles;
  return count;
}

std::vector<BodyLook> DrawnScene::Looks() const {
  std::vector<BodyLook> looks;
  for (const DrawnBody& body : bodies) {
    looks.push_back(body.look);
    if (!body.bounds_W.empty()) looks.back().middle_W = body.bounds_W.centre();
  }
  return looks;
}

DrawnBody MakeDrawnBody(const std::string& name, const BodyLook& look, const TriangleMesh& mesh_W) {
  return {name, look, Shade(mesh_W, kCreaseAngle), BoundsOf(mesh_W), mesh_W.triangles.size()};
}

}  // namespace tandem
