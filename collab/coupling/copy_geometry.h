#pragma once

#include "engine/base/spatial.h"

namespace tandem {

// Distances and velocities of a copy relative to the own instance. `per_mass` is a body's
// rotational inertia divided by its mass, I/m, in m^2; it turns rotations into lengths.

/// Distance between two poses in six dimensions, m. The energy of a link stretched by it is k
/// distance^2/2.
double LinkDistance(const Pose& a, const Pose& b, const Mat3& per_mass) noexcept;

/// Returns the copy's rotation, turned from the own one by at most 150 degrees. Beyond that the
/// moment stays constant and the sense of rotation is kept, since past 180 degrees the shortest way
/// is the other one. `turn`: the rotation vector from own to copy; `axis`: the sense of rotation,
/// kept from frame to frame.
Quat ClampedTurn(const Quat& q_own, const Quat& q_copy, const Vec3& turn, Vec3& axis) noexcept;

/// Returns the speed in m/s, rotation included.
double SpeedOf(const Twist& V_WB, const Mat3& per_mass) noexcept;

/// Returns `to`; where that differs from `from` by more than `most` m/s, the velocity at that
/// distance on the way to it.
Twist TwistTowards(const Twist& from, const Twist& to, double most, const Mat3& per_mass) noexcept;

}  // namespace tandem
