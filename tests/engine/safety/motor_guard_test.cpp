// Each test breaks a rule and measures what the motor gets.
#include "engine/safety/motor_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/safety/motor_rig.h"

namespace tandem {
namespace {

using testing::kNoNumber;
using testing::kTick;
using testing::Rig;

TEST(MotorGuard, GivesNoForceBeforeARamp) {
  Rig rig;
  for (int i = 0; i < 100; ++i) {
    rig.Tick();
    EXPECT_TRUE(rig.Nothing());
  }
  EXPECT_EQ(rig.guard.state(), SafetyState::kOff);
  ++rig.order.ramps;
  for (int i = 0; i < 1000; ++i) {
    rig.Tick();
    EXPECT_NEAR(rig.given.f.x(), 5 * 1e-3 * i, 1e-9);  // a second from nothing to the whole
  }
  rig.Tick();
  EXPECT_EQ(rig.guard.state(), SafetyState::kOn);
  EXPECT_NEAR(rig.given.f.x(), 5, 1e-9);
}

TEST(MotorGuard, ClampsToDeviceAndSafetyLimits) {
  Rig small({.limits = {3, 0.1}, .continuous = {3, 0.1}});
  small.Begin();
  small.order.F_D_W = {Vec3(0, 9, 0), Vec3(0, 300, 400)};
  small.Ticks(50);
  EXPECT_NEAR((small.given.f - Vec3(0, 1.8, 2.4)).norm(), 0, 1e-9);
  EXPECT_NEAR(small.given.tau.norm(), 0.1, 1e-9);
  small.ExpectWithinLimits(3, 0.1);
  EXPECT_GE(small.guard.counts().clamped, 50U);

  Rig boaster({.limits = {1e6, 1e6}, .continuous = {1e6, 1e6}});
  boaster.Begin();
  boaster.order.F_D_W = {Vec3(0, 1e5, 0), Vec3(1e300, 0, 0)};
  boaster.Ticks(50);
  EXPECT_NEAR(boaster.given.f.norm(), 30, 1e-9);
  EXPECT_NEAR(boaster.given.tau.norm(), 1, 1e-9);
  boaster.ExpectWithinLimits(30, 1);
}

TEST(MotorGuard, InvalidLimitIsZero) {
  for (const double claimed : {0.0, -3.0, kNoNumber, std::numeric_limits<double>::infinity()}) {
    Rig rig({.limits = {claimed, claimed}, .continuous = {5, 0.5}});
    ++rig.order.ramps;
    rig.Ticks(1200);
    EXPECT_EQ(rig.most, 0);
    EXPECT_EQ(rig.most_moment, 0);
  }
}

TEST(MotorGuard, StaleOrdersMeanDampingAfter5MillisecondsAndNoForceAfter20) {
  Rig rig;
  rig.Begin();
  rig.input.V_WD.v = Vec3(0, 0.2, 0);
  rig.Ticks(50);
  ASSERT_NEAR(rig.given.f.x(), 5, 1e-9);
  for (int age = 1; age <= 40; ++age) {  // 0.1 ms more
    rig.Tick(false);
    if (age < 5) {
      EXPECT_NEAR(rig.given.f.x(), 5, 1e-9);
      continue;
    }
    // it falls by the slew, 2 N a tick, towards damping alone: -2 N s/m times 0.2 m/s
    EXPECT_LE(rig.given.f.x(), std::max(0.0, 5 - 1.9 * (age - 4))) << age;
    if (age == 10) {
      EXPECT_NEAR((rig.given.f - Vec3(0, -0.4, 0)).norm(), 0, 1e-9);
    }
    if (age >= 19) {
      EXPECT_TRUE(rig.Nothing()) << age;
    }
  }
  EXPECT_EQ(rig.guard.state(), SafetyState::kExpired);
  EXPECT_EQ(rig.guard.counts().expired, 1U);
  rig.ExpectWithinLimits();
  // fresh orders alone do not bring it back
  rig.Ticks(100);
  EXPECT_TRUE(rig.Nothing());
  ++rig.order.ramps;
  rig.Ticks(500);
  EXPECT_EQ(rig.guard.state(), SafetyState::kRamping);
  EXPECT_NEAR(rig.given.f.x(), 2.5, 0.01);
}

// Thirty newtons are gone within 20 ms without a jump, the most that can be there.
TEST(MotorGuard, SlewLimitEndsTheLargestForceInTime) {
  Rig rig({.limits = {30, 1}, .continuous = {30, 1}});
  rig.order.F_D_W = {Vec3(0, 1, 0), Vec3(30, 0, 0)};
  rig.Begin();
  for (int age = 1; age <= 19; ++age) rig.Tick(false);
  EXPECT_TRUE(rig.Nothing());
  rig.ExpectWithinLimits(30, 1);
}

TEST(MotorGuard, FewLateOrdersCauseAShortRamp) {
  Rig rig;
  rig.Begin();
  rig.Ticks(8, false);
  EXPECT_EQ(rig.guard.state(), SafetyState::kDamping);
  rig.Tick();
  EXPECT_EQ(rig.guard.state(), SafetyState::kRamping);
  rig.Ticks(50);
  EXPECT_NEAR(rig.given.f.x(), 2.5, 0.1);
  rig.Ticks(60);
  EXPECT_EQ(rig.guard.state(), SafetyState::kOn);
  rig.ExpectWithinLimits();
}

// An order that is late once, early in the ramp-in of a second, must not make it one of a tenth.
TEST(MotorGuard, LateOrderDoesNotShortenTheCurrentRamp) {
  for (const int late_at : {10, 500, 950}) {
    Rig rig;
    ++rig.order.ramps;
    rig.Ticks(late_at);
    rig.Ticks(6, false);
    ASSERT_EQ(rig.guard.state(), SafetyState::kDamping);
    // the four ticks in which the order was not too old yet count; from there on a tick adds a
    // thousandth to the share, and below what it had come to a hundredth
    for (int i = 1; i <= 1100 - late_at; ++i) {
      rig.Tick();
      const double share = rig.given.f.x() / 5;
      EXPECT_LE(share, 1e-3 * (late_at + 4 + i) + 1e-9) << late_at << " and " << i;
      EXPECT_LE(share, 1e-2 * i + 1e-9) << late_at << " and " << i;
    }
    EXPECT_EQ(rig.guard.state(), SafetyState::kOn);
    rig.ExpectWithinLimits();
  }
}

// Late again and again: the ramp-in goes on only while orders come.
TEST(MotorGuard, ManyLateOrdersDoNotShortenTheCurrentRamp) {
  Rig rig;
  ++rig.order.ramps;
  rig.Ticks(10);
  for (int i = 0; i < 20; ++i) {
    rig.Ticks(6, false);
    rig.Ticks(20);
    EXPECT_LE(rig.given.f.x(), 5e-3 * (10 + 25 * (i + 1))) << i;
  }
}

TEST(MotorGuard, BeforeTheFirstOrderItIsOffAndNotLate) {
  Rig rig;
  rig.Ticks(100, false);
  EXPECT_EQ(rig.guard.state(), SafetyState::kOff);
  EXPECT_EQ(rig.guard.counts().zeroed, 0U);
}

// A late order must not have all of the damping in a tenth of a second's ramp-in.
TEST(MotorGuard, LateOrdersDampingFollowsTheRamp) {
  Rig rig;
  rig.order.F_D_W = {};
  rig.input.V_WD.v = Vec3(0, 0.2, 0);
  ++rig.order.ramps;
  rig.Ticks(100);
  double most = 0;
  for (int age = 1; age <= 12; ++age) most = std::max(most, rig.Tick(false).f.norm());
  EXPECT_GT(most, 0.09 * 0.4);
  EXPECT_LT(most, 0.11 * 0.4);
}

TEST(MotorGuard, TheMeanOfTenSecondsStaysWithinTheContinuousForce) {
  Rig rig({.limits = {3.3, 0.1}, .continuous = {0.88, 0.03}});
  rig.order.F_D_W = {Vec3(0, 0.3, 0), Vec3(9, 0, 0)};
  ++rig.order.ramps;
  std::vector<double> given;
  for (int i = 0; i < 40'000; ++i) given.push_back(rig.Tick().f.norm());
  double sum = 0;
  double largest = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    sum += given[i] - (i >= 10'000 ? given[i - 10'000] : 0);
    largest = std::max(largest, sum / 10'000);
  }
  EXPECT_LE(largest, 0.88 + 1e-9);
  EXPECT_GE(largest, 0.8);
  rig.ExpectWithinLimits(3.3, 0.1);
}

// The hand is pushed on in the way it goes: energy out of nothing.
TEST(MotorGuard, ControllerRepaysAnActivePortsEnergy) {
  for (const bool control : {false, true}) {
    Rig rig({.limits = {12, 0.5}, .continuous = {12, 0.5}, .passivity_control = control});
    rig.Begin();
    rig.order.F_D_W = {Vec3::Zero(), Vec3(0.15, 0, 0)};
    rig.input.V_WD.v = Vec3(0.1, 0, 0);
    rig.Ticks(20'000);
    if (control) {
      EXPECT_GT(rig.guard.passivity().least_J(), -1.1 * PassivityObserver::kAllowance);
    } else {
      EXPECT_LT(rig.guard.passivity().least_J(), -0.2);
    }
    rig.ExpectWithinLimits();
  }
}

// Whatever is asked for, in whatever order, at whatever time: nothing passes.
TEST(MotorGuard, NoInputExceedsTheLimits) {
  std::mt19937 random(11);
  const auto draw = [&] {
    switch (random() % 40) {
      case 0:
        return kNoNumber;
      case 1:
        return random() % 2 != 0 ? 1.0 / 0.0 : -1.0 / 0.0;
      case 2:
        return std::numeric_limits<double>::max();
      default:
        return std::pow(10.0, static_cast<int>(random() % 6) - 3) *
               (static_cast<double>(random() % 2001) / 1000 - 1);
    }
  };
  Rig rig;
  int with_force = 0;
  for (int i = 0; i < 300'000; ++i) {
    if (random() % 500 == 0) rig.order.ramps += static_cast<std::uint32_t>(random() % 3);
    if (random() % 5000 == 0) ++rig.order.stops;
    if (random() % 1000 == 0) ++rig.order.resumes;
    rig.input.stop_button = random() % 20'000 == 0;
    rig.input.failed = random() % 20'000 == 0;
    rig.input.slept = random() % 50'000 == 0;
    rig.input.V_WD.v = random() % 3000 == 0 ? Vec3(draw(), draw(), draw()) : Vec3(0.1, 0, 0);
    const bool wild = random() % 300 == 0;
    rig.order.F_D_W.f = wild ? Vec3(draw(), draw(), draw()) : Vec3(3, 40, 1);
    const double before = rig.given.f.norm();
    const bool fresh = random() % 2 != 0;
    const std::int64_t gap = random() % 5000 == 0 ? 30 * kTick : kTick;
    if (gap == kTick) {
      rig.Tick(fresh, gap);
    } else {  // a fall at once is right here
      const double step = rig.step;
      const double turn = rig.turn;
      rig.Tick(fresh, gap);
      ASSERT_TRUE(rig.Nothing()) << before;
      rig.step = step;
      rig.turn = turn;
    }
    if (rig.input.slept) rig.step = rig.turn = 0;
    with_force += rig.given.f.norm() > 1 ? 1 : 0;
    ASSERT_TRUE(rig.sound) << i;
    ASSERT_LE(rig.most, 12 + 1e-9) << i;
    ASSERT_LE(rig.step, 2 + 1e-9) << i;
  }
  EXPECT_GT(with_force, 10'000);
  rig.ExpectWithinLimits();
}

}  // namespace
}  // namespace tandem
