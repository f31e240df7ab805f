// Tests what ends a motor's force, and what brings it back after each cause.
#include <limits>

#include <gtest/gtest.h>

#include "engine/safety/motor_guard.h"
#include "tests/engine/safety/motor_rig.h"

namespace tandem {
namespace {

using testing::kNoNumber;
using testing::kTick;
using testing::Rig;

/// Brings a guard whose force is on into `state`, by the cause of it.
void Bring(Rig& rig, SafetyState state) {
  switch (state) {
    case SafetyState::kExpired:
      rig.Ticks(25, false);
      break;
    case SafetyState::kOverrun:
      rig.Tick(true, 30 * kTick);
      break;
    case SafetyState::kSuspended:
      rig.input.slept = true;
      rig.Tick();
      rig.input.slept = false;
      break;
    case SafetyState::kFault:
      rig.input.failed = true;
      rig.Tick();
      rig.input.failed = false;
      break;
    case SafetyState::kStopped:
      ++rig.order.stops;
      rig.Tick();
      break;
    default:
      break;
  }
}

// A cause that needs a person is not forgotten because a lesser one was there before, or comes
// after.
TEST(MotorGuard, GraverOfTwoCausesHolds) {
  const auto rank = [](SafetyState state) {
    switch (state) {
      case SafetyState::kOff:
        return 0;
      case SafetyState::kStopped:
        return 3;
      case SafetyState::kFault:
        return 2;
      default:
        return 1;
    }
  };
  constexpr SafetyState kAll[]{SafetyState::kOff,     SafetyState::kExpired,
                               SafetyState::kOverrun, SafetyState::kSuspended,
                               SafetyState::kFault,   SafetyState::kStopped};
  for (const SafetyState first : kAll) {
    for (const SafetyState second : kAll) {
      if (second == SafetyState::kOff) continue;  // nothing brings it about
      Rig rig;
      if (first == SafetyState::kOff) {
        rig.Ticks(10);
      } else {
        rig.Begin();
        Bring(rig, first);
        rig.Ticks(3, first != SafetyState::kExpired);
      }
      ASSERT_EQ(rig.guard.state(), first);
      Bring(rig, second);
      const SafetyState graver = rank(second) > rank(first) ? second : first;
      EXPECT_EQ(rig.guard.state(), graver) << NameOf(first) << ", then " << NameOf(second);
      rig.Ticks(100);
      EXPECT_EQ(rig.guard.state(), graver) << NameOf(first) << ", then " << NameOf(second);
      // a ramp-in that a program asks for ends what needs no person
      ++rig.order.ramps;
      rig.Ticks(50);
      const bool person = rank(graver) >= 2;
      EXPECT_EQ(rig.guard.state(), person ? graver : SafetyState::kRamping)
          << NameOf(first) << ", then " << NameOf(second);
      EXPECT_EQ(rig.Nothing(), person);
      ++rig.order.resumes;
      rig.Ticks(50);
      EXPECT_EQ(rig.guard.state(), SafetyState::kRamping);
    }
  }
}

// A cable is pulled: the read hangs, and a tick later the driver says that it failed.
TEST(MotorGuard, FailureAfterAHangNeedsAPerson) {
  Rig rig;
  rig.Begin();
  rig.Tick(true, 60 * kTick);
  ASSERT_EQ(rig.guard.state(), SafetyState::kOverrun);
  ++rig.order.ramps;  // a program asks for force while the driver is in trouble
  rig.input.failed = true;
  rig.Ticks(10);
  rig.input.failed = false;
  rig.Ticks(300);
  EXPECT_EQ(rig.guard.state(), SafetyState::kFault);
  EXPECT_TRUE(rig.Nothing());
}

TEST(MotorGuard, NonFiniteValueEndsTheForceUntilResumed) {
  for (int what = 0; what < 5; ++what) {
    Rig rig;
    rig.Begin();
    const MotorInput sound_input = rig.input;
    const MotorOrder sound_order = rig.order;
    if (what == 0) rig.order.F_D_W.f.z() = kNoNumber;
    if (what == 1) rig.order.F_D_W.tau.x() = std::numeric_limits<double>::infinity();
    if (what == 2) rig.input.V_WD.w.x() = kNoNumber;
    if (what == 3) rig.input.p_WD.x() = kNoNumber;
    if (what == 4) rig.input.failed = true;
    rig.Tick();
    EXPECT_EQ(rig.guard.state(), SafetyState::kFault) << what;
    rig.input.p_WD = sound_input.p_WD;
    rig.input.V_WD = sound_input.V_WD;
    rig.input.failed = false;
    rig.order.F_D_W = sound_order.F_D_W;
    rig.Ticks(6);
    EXPECT_TRUE(rig.Nothing());
    rig.Ticks(200);
    EXPECT_TRUE(rig.Nothing());
    EXPECT_EQ(rig.guard.counts().zeroed, 1U);
    ++rig.order.resumes;
    rig.Ticks(1100);
    EXPECT_NEAR(rig.given.f.x(), 5, 1e-9);
    rig.ExpectWithinLimits();
  }
}

TEST(MotorGuard, RampWaitsForTheCauseToEnd) {
  Rig rig;
  rig.Begin();
  rig.input.failed = true;
  rig.Tick();
  ++rig.order.ramps;
  rig.Ticks(100);
  EXPECT_EQ(rig.guard.state(), SafetyState::kFault);
  EXPECT_TRUE(rig.Nothing());
}

TEST(MotorGuard, ImplausiblyFastHandGetsNoForceUntilSlow) {
  Rig rig;
  rig.Begin();
  rig.input.V_WD.v = Vec3(0, 0, 1.2);
  rig.Ticks(7);
  EXPECT_EQ(rig.guard.state(), SafetyState::kTooFast);
  EXPECT_TRUE(rig.Nothing());
  rig.input.V_WD.v = Vec3(0, 0, 0.8);  // slower, yet not slow
  rig.Ticks(20);
  EXPECT_EQ(rig.guard.state(), SafetyState::kTooFast);
  rig.input.V_WD.v = Vec3(0, 0, 0.4);
  rig.Ticks(500);
  EXPECT_EQ(rig.guard.state(), SafetyState::kRamping);
  EXPECT_NEAR(rig.given.f.x(), 2.5, 0.02);
  EXPECT_EQ(rig.guard.counts().zeroed, 1U);
  rig.ExpectWithinLimits();
}

// The hand's orders cease while it is fast, and it is let in at 0.9 m/s.
TEST(MotorGuard, FastHandMustSlowDownBeforeForceReturns) {
  Rig rig;
  rig.Begin();
  rig.input.V_WD.v = Vec3(0, 0, 1.2);
  rig.Ticks(7);
  rig.Ticks(25, false);
  ASSERT_EQ(rig.guard.state(), SafetyState::kExpired);
  rig.input.V_WD.v = Vec3(0, 0, 0.8);
  ++rig.order.ramps;
  rig.Ticks(50);
  EXPECT_TRUE(rig.Nothing());
  rig.input.V_WD.v = Vec3(0, 0, 0.4);
  rig.Ticks(500);
  EXPECT_NEAR(rig.given.f.x(), 2.5, 0.02);
}

// The driver says that the handle rests, while it goes at 1.5 m/s.
TEST(MotorGuard, DriversSpeedIsNotTrusted) {
  Rig rig;
  rig.Begin();
  for (int i = 0; i < 30; ++i) {
    rig.input.p_WD.x() += 1.5e-3;
    rig.Tick();
  }
  EXPECT_EQ(rig.guard.state(), SafetyState::kTooFast);
  EXPECT_TRUE(rig.Nothing());
}

TEST(MotorGuard, EmergencyStopHoldsUntilResumed) {
  for (int way = 0; way < 2; ++way) {
    Rig rig;
    rig.Begin();
    if (way == 0) {
      ++rig.order.stops;
    } else {
      rig.input.stop_button = true;
    }
    rig.Ticks(6);
    EXPECT_TRUE(rig.Nothing());
    EXPECT_EQ(rig.guard.state(), SafetyState::kStopped);
    EXPECT_EQ(rig.guard.counts().stops, 1U);
    rig.input.stop_button = false;
    ++rig.order.ramps;  // a ramp-in does not end it
    rig.Ticks(100);
    EXPECT_TRUE(rig.Nothing());
    ++rig.order.resumes;
    rig.Ticks(500);
    EXPECT_NEAR(rig.given.f.x(), 2.5, 0.02);
    rig.Ticks(600);
    EXPECT_EQ(rig.guard.state(), SafetyState::kOn);
    rig.ExpectWithinLimits();
  }
}

TEST(MotorGuard, CannotResumeDuringAStopOrShutdown) {
  Rig rig;
  rig.Begin();
  rig.input.stop_button = true;
  rig.Ticks(10);
  ++rig.order.resumes;
  rig.Ticks(10);
  EXPECT_EQ(rig.guard.state(), SafetyState::kStopped);
  Rig ending;
  ending.Begin();
  ending.input.ending = true;
  ending.Ticks(6);
  EXPECT_TRUE(ending.Nothing());
  ++ending.order.resumes;
  ending.Ticks(100);
  EXPECT_TRUE(ending.Nothing());
  ending.ExpectWithinLimits();
}

TEST(MotorGuard, StalledLoopNeedsARamp) {
  Rig rig;
  rig.Begin();
  rig.Tick(true, 21 * kTick);
  EXPECT_EQ(rig.guard.state(), SafetyState::kOverrun);
  EXPECT_TRUE(rig.Nothing());
  rig.Ticks(100);
  EXPECT_TRUE(rig.Nothing());
  ++rig.order.ramps;
  rig.Ticks(1100);
  EXPECT_EQ(rig.guard.state(), SafetyState::kOn);
}

TEST(MotorGuard, SuspendedMachineNeedsARamp) {
  Rig rig;
  rig.Begin();
  rig.input.slept = true;
  rig.Tick();
  rig.input.slept = false;
  EXPECT_EQ(rig.guard.state(), SafetyState::kSuspended);
  EXPECT_TRUE(rig.Nothing());
  rig.Ticks(100);
  EXPECT_TRUE(rig.Nothing());
}

}  // namespace
}  // namespace tandem
