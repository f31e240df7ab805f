#pragma once

#include <cstdint>

#include "collab/simulated/hands/checkers/motor_checker.h"
#include "engine/safety/motor_guard.h"

namespace tandem {

/// A motor with the injected fault of the session: it changes the wrench that the guard gives.
class FaultyMotor {
 public:
  /// Returns the wrench that a checker is to see in this tick; `tick.given` is the guard's.
  Wrench Give(const MotorTick& tick, SafetyState state);

 private:
  std::uint64_t ticks_ = 0;
  Wrench kept_;  // wrench of the last tick with a fresh order, and 0.3 N
};

}  // namespace tandem
