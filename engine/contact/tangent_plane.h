#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/spatial.h"

namespace tandem {

/// How hard contact pushes back, at each point.
struct ContactGains {
  double stiffness = 0;  // N/m
  double damping = 0;    // N s/m, along the normal
  double friction = 0;   // Coulomb's mu
};

/// N/m at each point, of bodies however light: a voxel of depth on one point holds 50 N, more than
/// a hand gives.
constexpr double LeastContactStiffness(double voxel_size) {
  return 50.0 / voxel_size;
}

/// Stiff enough for that, and that one point stops a body of that mass (kg), arriving at the travel
/// limit of half a voxel a frame (h, s), within a voxel: m v^2 = K s^2 with v = s / (2 h).
/// Critically damped. The step is implicit, so neither has a limit.
inline ContactGains DefaultContactGains(double voxel_size, double mass, double h) {
  const double stiffness = std::max(LeastContactStiffness(voxel_size), 0.25 * mass / (h * h));
  return {.stiffness = stiffness, .damping = 2.0 * std::sqrt(stiffness * mass)};
}

/// The force of a contact at a depth (m): K d, and harder the deeper, so that one point of a body
/// that is pulled with hundreds of newtons still stops within two voxels. Over the first `soft` of
/// depth (m) stiffness grows from nothing to K: where it were there at once, a step of the body
/// would be held by all that it is about to touch.
inline double ContactForce(double stiffness, double depth, double voxel_size,
                           double soft = 0) noexcept {
  const double x = std::min(depth / voxel_size, 3.0);
  const double less = depth < soft ? depth - 0.5 * depth * depth / soft : 0.5 * soft;
  return stiffness * depth * (1.0 + 8.0 * x * x * x) - stiffness * less;
}
/// Its derivative by the depth.
inline double ContactStiffness(double stiffness, double depth, double voxel_size,
                               double soft = 0) noexcept {
  const double x = std::min(depth / voxel_size, 3.0);
  return stiffness *
         (std::min(1.0, soft > 0 ? depth / soft : 1.0) + (x < 3.0 ? 32.0 : 8.0) * x * x * x);
}

/// How far a point has gone below the tangent plane (paper §2.1, Figure 2; decision 0004), m; above
/// it negative. The plane passes through the centre of the voxel that the point is in,
/// perpendicular to the point's own normal `nhat`, which points into its body, away from what it
/// touches.
///
/// Deeper layers (value < 2 + layers) add a layer's thickness along the normal each: without that
/// the force would saw as a point goes from voxel to voxel, and vanish inside.
///
/// `p`, its voxel's `centre` and `nhat` in V; `value` the voxel's mark. `layers` goes from one
/// force layer to the next without a step: the next one's points are above their planes at first.
inline double TangentPlaneDepth(const Vec3& p, const Vec3& centre, const Vec3& nhat, int value,
                                double layers, double voxel_size) noexcept {
  return (centre - p).dot(nhat) + (2 + layers - value) * voxel_size * nhat.lpNorm<1>();
}

}  // namespace tandem
