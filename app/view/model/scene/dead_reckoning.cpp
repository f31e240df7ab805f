#include "app/view/model/scene/dead_reckoning.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

// smaller errors count as zero, so that a picture comes to rest
constexpr double kNothing = 1e-5;  // m, rad

bool Differs(const DeadReckoning::Told& a, const DeadReckoning::Told& b) {
  return a.seq != b.seq || a.X_W.p != b.X_W.p || a.X_W.q.coeffs() != b.X_W.q.coeffs();
}

/// Returns the pose with the middle at `p` and the rotation `q`.
Pose About(const Vec3& middle_W, const Vec3& p, const Quat& q) {
  return {q, p - q * middle_W};
}

}  // namespace

Pose DeadReckoning::Ahead(const Vec3& middle_W, double now_s) const {
  if (told_.V_W.v.isZero(0) && told_.V_W.w.isZero(0)) return told_.X_W;
  const double since = std::max(0.0, now_s - told_s_);
  // forwards until kLongest, then back at half the pace
  double ahead = std::max(0.0, std::min(since, kLongest - 0.5 * (since - kLongest)));
  const Vec3 middle = told_.X_W * middle_W;
  const Vec3 v = told_.V_W.v + told_.V_W.w.cross(middle - told_.X_W.p);
  ahead = std::min(ahead, kFarthest / std::max(v.norm(), 1e-9));
  const Quat q = RotationBy(ahead * told_.V_W.w) * told_.X_W.q;
  return About(middle_W, middle + ahead * v, q);
}

Pose DeadReckoning::Show(const Told& told, const Vec3& middle_W, double now_s) {
  const double fade = std::exp(-std::max(0.0, now_s - shown_s_) / kSettle);
  off_ *= fade;
  turned_ *= fade;
  shown_s_ = now_s;
  if (!begun_ || Differs(told, told_)) {
    const Pose before = Ahead(middle_W, now_s);
    const Vec3 shown = before * middle_W + off_;
    const Quat shown_q = RotationBy(turned_) * before.q;
    told_ = told;
    told_s_ = now_s;
    off_ = shown - told.X_W * middle_W;
    turned_ = RotationVector(shown_q * told.X_W.q.conjugate());
    if (!begun_ || off_.norm() > kJump) off_ = turned_ = Vec3::Zero();
    begun_ = true;
  }
  if (off_.norm() < kNothing && turned_.norm() < kNothing) {
    off_ = turned_ = Vec3::Zero();
    return Ahead(middle_W, now_s);
  }
  const Pose ahead = Ahead(middle_W, now_s);
  return About(middle_W, ahead * middle_W + off_, RotationBy(turned_) * ahead.q);
}

}  // namespace tandem
