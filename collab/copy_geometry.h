#pragma once

#include "engine/base/spatial.h"

namespace tandem {

// Where a copy of another's instance is from our own, and how fast it may seem to go. `per_mass`: a
// body's rotational inertia for each kilogram of it, I/m, which makes of a turn a length.

/// Between two poses in six dimensions, m: stretched by it, a link's energy is k distance^2/2.
double LinkDistance(const Pose& a, const Pose& b, const Mat3& per_mass) noexcept;

/// The copy's rotation, turned from ours by at most 150 degrees: beyond, the moment stays as it is
/// and the way round is kept, since past half a turn the shortest way is the other one. `turn`: the
/// rotation vector from ours to it; `axis`: the way round, kept from frame to frame.
Quat ClampedTurn(const Quat& q_own, const Quat& q_copy, const Vec3& turn, Vec3& axis) noexcept;

/// As far from one velocity of a copy to the next as that many m/s go.
Twist TwistTowards(const Twist& from, const Twist& to, double most, const Mat3& per_mass) noexcept;

}  // namespace tandem
