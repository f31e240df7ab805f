#pragma once

#include "engine/base/spatial.h"

namespace tandem {

/// How hard contact pushes back.
struct ContactGains {
  double stiffness = 5e4;  // N/m a point
  double damping = 50.0;   // N s/m a point, on approach only
};

/// 50 N for a voxel of depth, and half the critical damping of a third of a kilogram on one point.
inline ContactGains DefaultContactGains(double voxel_size) {
  const double stiffness = 50.0 / voxel_size;
  return {stiffness, std::sqrt(0.3 * stiffness)};
}

/// How far a point has gone below the tangent plane (paper §2.1, Figure 2; VPS.md §4.5), m; above it
/// negative. The plane passes through the centre of the voxel that the point is in, perpendicular to the
/// point's own normal `nhat`, which points into its body, away from what it touches.
///
/// Deeper layers (value < 2 + layer) add a layer's thickness along the normal each: without that the force
/// would saw as a point goes from voxel to voxel, and vanish inside.
///
/// `p`, its voxel's `centre` and `nhat` in V; `value` the voxel's mark.
inline double TangentPlaneDepth(const Vec3& p, const Vec3& centre, const Vec3& nhat, int value,
                                int layer, double voxel_size) noexcept {
  return (centre - p).dot(nhat) + (2 + layer - value) * voxel_size * nhat.lpNorm<1>();
}

}  // namespace tandem
