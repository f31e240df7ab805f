#pragma once

#include <algorithm>

#include "engine/base/spatial.h"

namespace tandem {

/// Watches the energy that goes through a device's port. A passive port gives a hand no more than
/// it took from it. A port that gives more is about to shake, or another user works through it. The
/// balance is capped at `kMostCredit`, so that long calm does not pay for later shaking.
///
/// If requested, the controller pays a debt beyond `kAllowance` back by damping (Hannaford and Ryu,
/// "Time-Domain Passivity Control of Haptic Interfaces", 2002).
class PassivityObserver {
 public:
  static constexpr double kMostCredit = 0.5;  // J
  static constexpr double kAllowance = 0.05;  // J

  /// Notes that the handle got F_D_W while it moved by V_WD, for `h` seconds.
  void Observe(const Wrench& F_D_W, const Twist& V_WD, double h) noexcept {
    const double taken_J = -h * (F_D_W.f.dot(V_WD.v) + F_D_W.tau.dot(V_WD.w));
    balance_J_ = std::min(balance_J_ + taken_J, kMostCredit);
    least_J_ = std::min(least_J_, balance_J_);
  }

  /// Returns the energy taken from the hand less that given to it, J; negative: the port is active.
  double balance_J() const noexcept { return balance_J_; }
  double least_J() const noexcept { return least_J_; }
  bool active() const noexcept { return balance_J_ < -kAllowance; }

  /// Returns the damping force that pays the debt back within a step of `h` seconds, by at most
  /// `most` N s/m.
  Vec3 DampingForce(const Twist& V_WD, double h, double most) const noexcept {
    const double speed2 = V_WD.v.squaredNorm();
    if (!active() || speed2 < 1e-8) return Vec3::Zero();
    return -std::min(most, (-balance_J_ - kAllowance) / (speed2 * h)) * V_WD.v;
  }

 private:
  double balance_J_ = 0;
  double least_J_ = 0;
};

}  // namespace tandem
