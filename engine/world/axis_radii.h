#pragma once

#include "engine/base/spatial.h"
#include "engine/world/world_model.h"

namespace tandem {

/// How far a body's surface lies from its principal axes. A surface point moves by the rotation as
/// far as it lies from the axis, and a slender body turns about its own axis most often.
struct AxisRadii {
  Mat3 axes_B = Mat3::Identity();  // principal axes, as columns
  Vec3 radii = Vec3::Zero();       // m, the greatest distance of the surface from each
  double radius = 0;               // m, the same from the centre of mass

  /// Returns a bound of the surface's distance from the axis of a rotation, m.
  double About(const Vec3& w_B) const noexcept {
    const double norm = w_B.norm();
    if (!(norm > 0)) return radius;
    const Vec3 along = (axes_B.transpose() * w_B / norm).cwiseAbs();
    return std::min(radius, along.dot(radii));
  }
};

/// Measures the mesh of a body of the refined contact model. Other bodies have one radius for all
/// axes.
AxisRadii AxisRadiiOf(const WorldModel& model, std::size_t body);

}  // namespace tandem
