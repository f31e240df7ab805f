#include "app/judgement/nearest_body.h"

#include "engine/geometry/exact/mesh_tree.h"

namespace tandem {

std::optional<NearestBody> NearestTo(const WorldModel& model, std::size_t body,
                                     const std::vector<Pose>& bodies_WB, double at_most) {
  const auto placed = [&](std::size_t mesh) {
    const int b = model.body_index[mesh];
    if (b < 0) return model.meshes_W[mesh];
    const auto moving = static_cast<std::size_t>(b);
    return Transformed(model.meshes_W[mesh],
                       bodies_WB[moving] * model.bodies[moving].X_WB0.Inverse());
  };
  TriangleMesh part_W;
  for (std::size_t i = 0; i < model.meshes_W.size(); ++i) {
    if (model.body_index[i] == static_cast<int>(body)) Append(part_W, placed(i));
  }
  const Bounds part = BoundsOf(part_W);
  const Bounds near{part.min - Vec3::Constant(at_most), part.max + Vec3::Constant(at_most)};
  const MeshTree tree(part_W);
  std::optional<NearestBody> nearest;
  for (std::size_t i = 0; i < model.meshes_W.size(); ++i) {
    if (model.body_index[i] == static_cast<int>(body)) continue;
    const TriangleMesh other_W = placed(i);
    if (!near.Overlaps(BoundsOf(other_W))) continue;
    const ClosestPoints closest =
        FindClosestPoints(tree, Pose{}, MeshTree(other_W), {.at_most = at_most});
    if (closest.distance > at_most) continue;
    at_most = closest.distance;
    nearest = {.name = model.scene.bodies[i].name, .distance = closest.distance};
  }
  return nearest;
}

}  // namespace tandem
