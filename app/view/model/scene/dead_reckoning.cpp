#include "app/view/model/scene/dead_reckoning.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

// smaller errors count as zero, so that a picture comes to rest
constexpr double kNothing = 1e-5;  // m, rad

bool Differs(const DeadReckoning::ReceivedMotion& a, const DeadReckoning::ReceivedMotion& b) {
  return a.seq != b.seq || a.X_W.p != b.X_W.p || a.X_W.q.coeffs() != b.X_W.q.coeffs();
}

/// Returns the pose with the middle at `p` and the rotation `q`.
Pose RotatedAbout(const Vec3& middle_W, const Vec3& p, const Quat& q) {
  return {q, p - q * middle_W};
}

}  // namespace

Pose DeadReckoning::Extrapolate(const Vec3& middle_W, double now_s) const {
  if (reported_.V_W.v.isZero(0) && reported_.V_W.w.isZero(0)) return reported_.X_W;
  const double since = std::max(0.0, now_s - told_s_);
  // forwards until kLongest, then back at half the pace
  double ahead = std::max(0.0, std::min(since, kLongest - 0.5 * (since - kLongest)));
  const Vec3 middle = reported_.X_W * middle_W;
  const Vec3 v = reported_.V_W.v + reported_.V_W.w.cross(middle - reported_.X_W.p);
  ahead = std::min(ahead, kFarthest / std::max(v.norm(), 1e-9));
  const Quat q = RotationBy(ahead * reported_.V_W.w) * reported_.X_W.q;
  return RotatedAbout(middle_W, middle + ahead * v, q);
}

Pose DeadReckoning::Show(const ReceivedMotion& reported, const Vec3& middle_W, double now_s) {
  const double fade = std::exp(-std::max(0.0, now_s - shown_s_) / kSettle);
  off_ *= fade;
  turned_ *= fade;
  shown_s_ = now_s;
  if (!begun_ || Differs(reported, reported_)) {
    const Pose before = Extrapolate(middle_W, now_s);
    const Vec3 shown = before * middle_W + off_;
    const Quat shown_q = RotationBy(turned_) * before.q;
    reported_ = reported;
    told_s_ = now_s;
    off_ = shown - reported.X_W * middle_W;
    turned_ = RotationVector(shown_q * reported.X_W.q.conjugate());
    if (!begun_ || off_.norm() > kJump) off_ = turned_ = Vec3::Zero();
    begun_ = true;
  }
  if (off_.norm() < kNothing && turned_.norm() < kNothing) {
    off_ = turned_ = Vec3::Zero();
    return Extrapolate(middle_W, now_s);
  }
  const Pose ahead = Extrapolate(middle_W, now_s);
  return RotatedAbout(middle_W, ahead * middle_W + off_, RotationBy(turned_) * ahead.q);
}

}  // namespace tandem
