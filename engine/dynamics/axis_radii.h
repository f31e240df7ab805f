#pragma once

#include <algorithm>

#include "engine/base/spatial.h"

namespace tandem {

/// How far a body's surface lies from its principal axes. A rotation moves a surface point as far
/// as it lies from the axis, and a slender body turns about its own axis most often.
struct AxisRadii {
  Mat3 axes_B = Mat3::Identity();  // principal axes, as columns
  Vec3 radii = Vec3::Zero();       // m, the greatest distance of the surface from each
  double radius = 0;               // m, the same from the centre of mass
  double displaced = 0;            // m, how far the surface is displaced, either way

  /// Returns the same for all axes.
  static AxisRadii Ball(double radius) {
    return {.radii = Vec3::Constant(radius), .radius = radius};
  }
  AxisRadii Displaced(double by) const {
    AxisRadii all = *this;
    all.displaced += by;
    return all;
  }
  /// Returns a bound of the surface's distance from the axis of a rotation, m. A point p lies
  /// |p x u| from the axis u, and u is a sum of principal axes.
  double About(const Vec3& w_B) const noexcept {
    const double norm = w_B.norm();
    if (!(norm > 0)) return radius + displaced;
    const Vec3 along = (axes_B.transpose() * w_B / norm).cwiseAbs();
    return std::min(radius, along.dot(radii)) + displaced;
  }
};

}  // namespace tandem
