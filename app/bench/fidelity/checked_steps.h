#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "app/bench/fidelity/fidelity.h"
#include "app/bench/fidelity/push_judge.h"

namespace tandem {

/// Steps a world whose first body a hand holds, and checks what contact does to it. It compares the
/// reported force with the change of momentum, and pushes of refined contact with exact geometry.
class CheckedSteps {
 public:
  /// Judges about `contacts` contacts over `frames` frames, if there are as many; 0: none.
  CheckedSteps(const WorldModel& model, std::size_t contacts, std::size_t frames);

  /// Steps one frame, timed without its checks.
  TimedFrame Step(World& world, const StepInputs& inputs, TimesOfFrames& times);

  /// Returns the checks of all frames so far. It judges pushes only here, so that frames have the
  /// caches to themselves.
  ContactChecks Checks();

 private:
  struct Push {
    Vec3 p_W;
    Vec3 nhat_W;
    Pose X_WB;
    double force;  // N
  };
  void KeepPushes(const World& world, const Pose& X_WB);

  double contacts_a_frame_;
  std::unique_ptr<PushJudge> judge_;  // null: no pushes are judged
  std::size_t frame_ = 0;
  std::vector<Push> pushes_;
  ContactChecks checks_;
};

}  // namespace tandem
