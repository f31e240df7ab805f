#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/spatial.h"

namespace tandem {

/// The gains of contact at each point.
struct ContactGains {
  double stiffness = 0;  // N/m
  double damping = 0;    // N s/m, along the normal
  double friction = 0;   // Coulomb's mu
};

/// Returns the least stiffness at each point, N/m, however light the body: a voxel of depth on one
/// point holds 50 N, more than a hand gives.
constexpr double LeastContactStiffness(double voxel_size) {
  return 50.0 / voxel_size;
}

/// Returns gains of at least that stiffness, with which one point stops a body of mass `mass` (kg)
/// within a voxel. The body arrives at the travel limit of half a voxel a frame (`h`, s):
/// m v^2 = K s^2 with v = s / (2 h). They are critically damped. The step is implicit, so neither
/// has a limit.
inline ContactGains DefaultContactGains(double voxel_size, double mass, double h) {
  const double stiffness = std::max(LeastContactStiffness(voxel_size), 0.25 * mass / (h * h));
  return {.stiffness = stiffness, .damping = 2.0 * std::sqrt(stiffness * mass)};
}

/// Returns the force of a contact at a depth (m): K d, and progressively harder. So one point stops
/// a body that hundreds of newtons pull within two voxels. Over the first `soft` of depth (m)
/// stiffness grows from nothing to K. With full stiffness from the start, all that a body is about
/// to touch would hold its step.
inline double ContactForce(double stiffness, double depth, double voxel_size,
                           double soft = 0) noexcept {
  const double x = std::min(depth / voxel_size, 3.0);
  const double less = depth < soft ? depth - 0.5 * depth * depth / soft : 0.5 * soft;
  return stiffness * depth * (1.0 + 8.0 * x * x * x) - stiffness * less;
}
/// Returns the derivative of the force by the depth.
inline double ContactStiffness(double stiffness, double depth, double voxel_size,
                               double soft = 0) noexcept {
  const double x = std::min(depth / voxel_size, 3.0);
  return stiffness *
         (std::min(1.0, soft > 0 ? depth / soft : 1.0) + (x < 3.0 ? 32.0 : 8.0) * x * x * x);
}

/// Returns how far a point is below the tangent plane (paper §2.1, Figure 2; decision 0004), m;
/// negative above it. The plane passes through the centre of the voxel that the point is in. It is
/// perpendicular to the point's own normal `nhat`, which points into its body, away from what it
/// touches.
///
/// Deeper layers (value < 2 + layers) add a layer's thickness along the normal each. Otherwise the
/// force would form a sawtooth as a point goes from voxel to voxel, and vanish inside.
///
/// `p`, its voxel's `centre` and `nhat` are in V; `value` is the voxel's mark. `layers` can go from
/// one force layer to the next without a step: at first the points of the next layer are above
/// their planes.
inline double TangentPlaneDepth(const Vec3& p, const Vec3& centre, const Vec3& nhat, int value,
                                double layers, double voxel_size) noexcept {
  return (centre - p).dot(nhat) + (2 + layers - value) * voxel_size * nhat.lpNorm<1>();
}

}  // namespace tandem
