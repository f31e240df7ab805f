#pragma once

#include <cstddef>

#include "engine/base/spatial.h"
#include "engine/geometry/exact/exact_surface.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A depth that a search has found.
struct BoundedDepth {
  double depth = 0;  // m
  double error = 0;  // m; the greatest depth is at most depth + error
};

/// Finds the greatest depth of a moving mesh in a fixture at one pose, 0 if they do not overlap, by
/// branch and bound over its triangles: depth changes by no more than a point moves, no point is
/// deeper than it is far from any facet, and a piece that is outside and meets no facet is outside
/// as a whole. `at_least`: a depth (m) that a point of the mesh has. Ends when the error is at most
/// `tolerance` (m), or after `most_looks` depths. A mesh of more triangles is not searched: then
/// the error is infinite.
BoundedDepth GreatestDepth(const ExactSurface& fixture_F, const TriangleMesh& moving_B,
                           const Pose& X_FB, double at_least, double tolerance,
                           std::size_t most_looks = 40'000);

}  // namespace tandem
