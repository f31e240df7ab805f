#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "engine/safety/motor_guard.h"

namespace tandem::testing {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::int64_t kTick = 1'000'000;  // ns

/// A device's ticks, a millisecond each, and the forces that its motor got.
class Rig {
 public:
  explicit Rig(const MotorGuard::Options& options = {.limits = {12, 0.5}, .continuous = {12, 0.5}})
      : guard(options) {
    input.now_ns = 1000 * kTick;
    order.F_D_W.f = Vec3(5, 0, 0);
    order.F_D_W.tau = Vec3(0, 0.2, 0);
  }
  /// Runs one tick; `fresh`: the controller has answered it.
  Wrench Tick(bool fresh = true, std::int64_t after_ns = kTick) {
    input.now_ns += after_ns;
    if (fresh) order.input_ns = input.now_ns - kTick / 10;
    const Wrench before = given;
    given = guard.Pass(input, order);
    sound = sound && given.f.allFinite() && given.tau.allFinite();
    most = std::max(most, given.f.norm());
    most_moment = std::max(most_moment, given.tau.norm());
    step = std::max(step, (given.f - before.f).norm());
    turn = std::max(turn, (given.tau - before.tau).norm());
    return given;
  }
  void Ticks(int count, bool fresh = true) {
    for (int i = 0; i < count; ++i) Tick(fresh);
  }
  /// Begins with force on.
  void Begin() {
    ++order.ramps;
    Ticks(1100);
    ASSERT_EQ(guard.state(), SafetyState::kOn);
  }
  bool Nothing() const { return given.f.isZero() && given.tau.isZero(); }
  void ExpectWithinLimits(double force = 12, double moment = 0.5) const {
    EXPECT_TRUE(sound);
    EXPECT_LE(most, force + 1e-9);
    EXPECT_LE(most_moment, moment + 1e-9);
    EXPECT_LE(step, force / 6 + 1e-9);
    EXPECT_LE(turn, moment / 6 + 1e-9);
  }

  MotorGuard guard;
  MotorInput input;
  MotorOrder order;
  Wrench given;
  bool sound = true;
  double most = 0, most_moment = 0, step = 0, turn = 0;
};

}  // namespace tandem::testing
