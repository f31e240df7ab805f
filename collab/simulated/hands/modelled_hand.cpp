#include "collab/simulated/hands/modelled_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem {

namespace {

constexpr double kTick = 1e-3;           // s
constexpr double kMass = 0.4;            // kg, hand and handle
constexpr double kArmStiffness = 400.0;  // N/m
constexpr double kArmDamping = 18.0;     // N s/m, relative to the intended motion
constexpr double kInertia = 1e-3;        // kg m^2
constexpr double kLongestWay = 0.35;     // m, in one move
constexpr double kWristStiffness = 4.0;  // N m/rad
constexpr double kWristDamping = 0.1;    // N m s/rad

}  // namespace

void ModelledHand::Aim() noexcept {
  from_ = to_;
  gone_s_ = 0;
  const double mood = rng_.Uniform(0, 1);
  const bool wild = mood < 0.06;  // faster than anybody works
  to_ = {rng_.Turn(wild ? 1.2 : 0.4), rng_.Place(wild ? 0.2 : 0.06)};
  // the highest speed is 1.9 times the mean
  const Vec3 way = to_.p - from_.p;
  if (way.norm() > kLongestWay) to_.p = from_.p + kLongestWay / way.norm() * way;
  way_s_ = wild ? rng_.Uniform(0.3, 0.5) : rng_.Uniform(0.3, 1.5);
  if (mood > 0.85) to_ = from_;  // the hand waits
}

Anchor ModelledHand::Read() noexcept {
  if (gone_s_ >= way_s_ && !rests_) Aim();
  gone_s_ = std::min(gone_s_ + kTick, way_s_);
  const double t = gone_s_ / way_s_;
  const double share = t * t * t * (10 - 15 * t + 6 * t * t);  // minimum jerk
  const Pose goal{from_.q.slerp(share, to_.q), from_.p + share * (to_.p - from_.p)};
  const double rate = 30 * t * t * (1 - t) * (1 - t) / way_s_;
  const Vec3 goal_v = t < 1 ? Vec3(rate * (to_.p - from_.p)) : Vec3(Vec3::Zero());

  Twist& V = handle_.V_WA;
  Pose& X = handle_.X_WA;
  const Vec3 f = kArmStiffness * (goal.p - X.p) + kArmDamping * (goal_v - V.v) + given_.f;
  const Vec3 tau =
      kWristStiffness * RotationVector(goal.q * X.q.conjugate()) - kWristDamping * V.w + given_.tau;
  V.v += kTick / kMass * f;
  V.w += kTick / kInertia * tau;
  X.p += kTick * V.v;
  X.q = (RotationBy(kTick * V.w) * X.q).normalized();
  if (!nonsense) return handle_;
  Anchor nowhere = handle_;
  nowhere.X_WA.p.x() = std::numeric_limits<double>::quiet_NaN();
  return nowhere;
}

}  // namespace tandem
