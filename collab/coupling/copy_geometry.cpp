#include "collab/coupling/copy_geometry.h"

#include <cmath>

namespace tandem {

namespace {

constexpr double kMostTurn = 150.0 * M_PI / 180.0;  // rad; greatest turn of a link's moment

}  // namespace

double LinkDistance(const Pose& a, const Pose& b, const Mat3& per_mass) noexcept {
  const Vec3 theta = RotationVector(b.q * a.q.conjugate());
  return std::sqrt((b.p - a.p).squaredNorm() + theta.dot(per_mass * theta));
}

Quat ClampedTurn(const Quat& q_own, const Quat& q_copy, const Vec3& turn, Vec3& axis) noexcept {
  const double angle = turn.norm();
  if (angle < 1e-6) return q_copy;
  const Vec3 now = turn / angle;
  if (angle < kMostTurn) {
    axis = now;
    return q_copy;
  }
  if (now.dot(axis) > 0) axis = now;
  return RotationBy(kMostTurn * axis) * q_own;
}

double SpeedOf(const Twist& V_WB, const Mat3& per_mass) noexcept {
  return std::sqrt(V_WB.v.squaredNorm() + V_WB.w.dot(per_mass * V_WB.w));
}

Twist TwistTowards(const Twist& from, const Twist& to, double most, const Mat3& per_mass) noexcept {
  const Twist way{to.w - from.w, to.v - from.v};
  const double size = std::sqrt(way.v.squaredNorm() + way.w.dot(per_mass * way.w));
  if (size <= most) return to;
  return {from.w + most / size * way.w, from.v + most / size * way.v};
}

}  // namespace tandem
