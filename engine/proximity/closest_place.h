#pragma once

#include <limits>

#include "engine/geometry/exact/mesh_tree.h"
#include "engine/geometry/exact/tree_pair.h"
#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {

/// Returns the place on a mesh that is nearest to another.
inline Vec3 ClosestTo(const MeshTree& mesh, const Vec3& place) noexcept {
  double least = std::numeric_limits<double>::infinity();
  Vec3 closest = place;
  VisitNearLeaves(mesh.tree, place, least, [&](const BoxTree::Node& leaf) {
    for (std::uint32_t k = leaf.first; k < leaf.first + leaf.count; ++k) {
      const auto& [a, b, c] = mesh.triangles[k];
      const Vec3 point = ClosestOnTriangle(a, b, c, place).point;
      const double squared = (point - place).squaredNorm();
      if (squared >= least) continue;
      least = squared;
      closest = point;
    }
    return least;
  });
  return closest;
}

}  // namespace tandem
