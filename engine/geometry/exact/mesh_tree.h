#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "engine/geometry/exact/box_tree.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A mesh's triangles in a tree of boxes, for queries of distance. Read-only once built.
struct MeshTree {
  MeshTree() = default;
  explicit MeshTree(const TriangleMesh& mesh);

  BoxTree tree;
  std::vector<std::array<Vec3, 3>> triangles;  // in the tree's order, m
};

/// Bounds of a search for the closest points.
struct ClosestPointsOptions {
  double at_most = std::numeric_limits<double>::infinity();  // known upper bound of the distance
  double tolerance = 0;                                      // allowed excess of the result, m
  std::size_t most_pairs = std::numeric_limits<std::size_t>::max();  // pairs of boxes or triangles
};

/// The result of the search. The distance of the two surfaces lies in [least, distance]. When the
/// search is complete, least is within the tolerance of it.
struct ClosestPoints {
  double distance = std::numeric_limits<double>::infinity();  // m; infinity: nothing found yet
  double least = 0;
  Vec3 p_BA = Vec3::Zero();  // on A's surface, in B
  Vec3 p_BB = Vec3::Zero();  // on B's surface
};

/// Returns the distance of two triangle surfaces, in double precision: 0 where they cross. There is
/// no inside or outside. `X_BA` takes A's frame to B's. Does not allocate.
ClosestPoints FindClosestPoints(const MeshTree& a, const Pose& X_BA, const MeshTree& b,
                                const ClosestPointsOptions& options) noexcept;

}  // namespace tandem
