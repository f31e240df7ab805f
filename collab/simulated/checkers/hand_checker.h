#pragma once

#include <vector>

#include "collab/simulated/checkers/violations.h"
#include "engine/base/spatial.h"

namespace tandem {

/// Judges the wrench that a person's hand gets, frame by frame: finite, within the device's clamp,
/// and changing by no more than the slew.
class HandChecker {
 public:
  static constexpr double kMostForce = 12;         // N
  static constexpr double kMostForceStep = 2;      // N, from one frame to the next
  static constexpr double kMostMoment = 0.5;       // N m
  static constexpr double kMostMomentStep = 0.08;  // N m

  HandChecker(std::size_t peers, Violations& violations)
      : violations_(&violations), given_(peers) {}

  /// Judges what the hand of a scheduled peer gets in this frame.
  void RenderedForces(std::size_t peer, PeerId id, const Wrench& F_D_W) {
    if (!F_D_W.f.allFinite() || !F_D_W.tau.allFinite()) {
      return violations_->Add("a hand's force is not finite", id);
    }
    constexpr double kRounding = 1e-9;
    const double force = F_D_W.f.norm();
    const double moment = F_D_W.tau.norm();
    if (force > kMostForce + kRounding) {
      violations_->Add("a hand's force is beyond the clamp", id, Text("%.2f N", force));
    }
    if (moment > kMostMoment + kRounding) {
      violations_->Add("a hand's moment is beyond the clamp", id, Text("%.3f N m", moment));
    }
    const double step = (F_D_W.f - given_[peer].f).norm();
    if (step > kMostForceStep + kRounding) {
      violations_->Add("a hand's force jumps", id, Text("%.2f N in a frame", step));
    }
    const double moment_step = (F_D_W.tau - given_[peer].tau).norm();
    if (moment_step > kMostMomentStep + kRounding) {
      violations_->Add("a hand's moment jumps", id, Text("%.3f N m in a frame", moment_step));
    }
    given_[peer] = F_D_W;
  }

  const Wrench& given(std::size_t peer) const { return given_[peer]; }

 private:
  Violations* violations_;
  std::vector<Wrench> given_;  // wrenches in the last frame
};

}  // namespace tandem
