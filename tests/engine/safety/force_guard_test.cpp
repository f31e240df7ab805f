#include "engine/safety/force_guard.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Wrench WrenchOf(double f, double tau = 0) {
  return {Vec3(0, tau, 0), Vec3(f, 0, 0)};
}

/// Returns a guard that is past the ramp.
ForceGuard Warm(const DeviceLimits& limits = {}) {
  ForceGuard guard(limits);
  for (int i = 0; i < ForceGuard::kRampFrames; ++i) guard.Pass({});
  return guard;
}

TEST(ForceGuard, OrdinaryForcesPassUnchanged) {
  ForceGuard guard = Warm();
  for (int i = 0; i < 1000; ++i) {
    const Wrench wanted{Vec3(0.2 * std::sin(0.01 * i), 0, 0.1), Vec3(0, 8 * std::sin(0.01 * i), 1)};
    if (i < 3) {  // from nothing to this
      guard.Pass(wanted);
      continue;
    }
    const Wrench given = guard.Pass(wanted);
    EXPECT_LT((given.f - wanted.f).norm(), 1e-12);
    EXPECT_LT((given.tau - wanted.tau).norm(), 1e-12);
  }
  EXPECT_LE(guard.guarded(), 3U);
  EXPECT_EQ(guard.frames(), 1000U + ForceGuard::kRampFrames);
}

TEST(ForceGuard, RampsFromZeroAfterEachStart) {
  ForceGuard guard = Warm();
  for (int i = 0; i < 20; ++i) guard.Pass(WrenchOf(5, 0.2));
  guard.Begin();
  for (int i = 0; i < 10; ++i) guard.Pass(WrenchOf(5, 0.2));  // it falls by the slew
  for (int i = 10; i < ForceGuard::kRampFrames; ++i) {
    const double share = (i + 1.0) / ForceGuard::kRampFrames;
    const Wrench given = guard.Pass(WrenchOf(5, 0.2));
    EXPECT_NEAR(given.f.x(), 5 * share, 1e-12);
    EXPECT_NEAR(given.tau.y(), 0.2 * share, 1e-12);
  }
  EXPECT_NEAR(guard.Pass(WrenchOf(5)).f.x(), 5, 1e-12);
}

TEST(ForceGuard, LimitingKeepsTheDirection) {
  ForceGuard guard = Warm();
  Wrench given;
  for (int i = 0; i < 50; ++i) given = guard.Pass({Vec3(3, 0, 4), Vec3(-300, 400, 0)});
  EXPECT_LT((given.f - 12 * Vec3(-0.6, 0.8, 0)).norm(), 1e-9);
  EXPECT_LT((given.tau - 0.5 * Vec3(0.6, 0, 0.8)).norm(), 1e-9);
  EXPECT_EQ(guard.guarded(), 50U);
}

TEST(ForceGuard, EnforcesTheDevicesLimits) {
  ForceGuard guard = Warm({.force = 3, .moment = 0.1});
  for (int i = 0; i < 50; ++i) guard.Pass(WrenchOf(100, 100));
  EXPECT_NEAR(guard.Pass(WrenchOf(100, 100)).f.norm(), 3, 1e-9);
  EXPECT_NEAR(guard.Pass(WrenchOf(100, 100)).tau.norm(), 0.1, 1e-9);
}

TEST(ForceGuard, NonFiniteForceIsZeroUntilTheNextStart) {
  for (const double bad : {kNan, kInf, -kInf}) {
    for (const Wrench& wrong : {WrenchOf(bad), WrenchOf(1, bad)}) {
      ForceGuard guard = Warm();
      for (int i = 0; i < 20; ++i) guard.Pass(WrenchOf(10));
      guard.Pass(wrong);
      EXPECT_TRUE(guard.broken());
      for (int i = 0; i < 10; ++i) guard.Pass(WrenchOf(10));
      EXPECT_TRUE(guard.Pass(WrenchOf(10)).f.isZero());
      guard.Begin();
      EXPECT_FALSE(guard.broken());
      for (int i = 0; i < ForceGuard::kLongRampFrames; ++i) guard.Pass(WrenchOf(10));
      EXPECT_NEAR(guard.Pass(WrenchOf(10)).f.x(), 10, 1e-9);
    }
  }
}

// Nobody expects the force to come back. It takes a second, and no grab meanwhile makes that
// shorter.
TEST(ForceGuard, RampsForASecondAfterAStopOrFault) {
  for (const bool fault : {false, true}) {
    for (const bool grab : {false, true}) {
      ForceGuard guard = Warm();
      for (int i = 0; i < 20; ++i) guard.Pass(WrenchOf(10));
      fault ? guard.Fail() : guard.Stop();
      for (int i = 0; i < 20; ++i) guard.Pass(WrenchOf(10));
      EXPECT_TRUE(guard.Pass(WrenchOf(10)).f.isZero());
      guard.Begin();  // a grab ends neither
      EXPECT_TRUE(guard.Pass(WrenchOf(10)).f.isZero());
      EXPECT_EQ(guard.state(), fault ? SafetyState::kFault : SafetyState::kStopped);
      guard.Resume();
      for (int i = 1; i <= 1000; ++i) {
        if (grab && i == 5) guard.Begin();
        EXPECT_LE(guard.Pass(WrenchOf(10)).f.x(), 1e-2 * i + 1e-9) << i;
      }
      EXPECT_NEAR(guard.Pass(WrenchOf(10)).f.x(), 10, 1e-9);
      EXPECT_EQ(guard.state(), SafetyState::kOn);
    }
  }
}

// Whatever is asked for, in whatever order: nothing passes the limits or the slew.
TEST(ForceGuard, NoInputExceedsTheLimits) {
  std::mt19937 random(3);
  const auto draw = [&] {
    switch (random() % 12) {
      case 0:
        return kNan;
      case 1:
        return random() % 2 != 0 ? kInf : -kInf;
      case 2:
        return std::numeric_limits<double>::max();
      case 3:
        return std::numeric_limits<double>::denorm_min();
      default:
        return std::pow(10.0, static_cast<int>(random() % 8) - 4) *
               (static_cast<double>(random() % 2001) / 1000 - 1);
    }
  };
  ForceGuard guard({});
  Wrench last;
  for (int i = 0; i < 200'000; ++i) {
    if (random() % 50 == 0) guard.Begin();
    Wrench wanted;
    if (random() % 3 != 0) wanted.f = Vec3(draw(), draw(), draw());
    if (random() % 3 != 0) wanted.tau = Vec3(draw(), draw(), draw());
    // long stretches of numbers, so that not all is stopped
    if (i / 1000 % 2 == 0 && !(wanted.f.allFinite() && wanted.tau.allFinite())) continue;
    const Wrench given = guard.Pass(wanted);
    ASSERT_TRUE(given.f.allFinite() && given.tau.allFinite()) << i;
    ASSERT_LE(given.f.norm(), 12 + 1e-9) << i;
    ASSERT_LE(given.tau.norm(), 0.5 + 1e-9) << i;
    ASSERT_LE((given.f - last.f).norm(), ForceGuard::kForceStep + 1e-9) << i;
    ASSERT_LE((given.tau - last.tau).norm(), ForceGuard::kMomentStep + 1e-9) << i;
    last = given;
  }
}

TEST(ForceGuard, CountsStopsAndFaultsOnce) {
  ForceGuard guard = Warm();
  for (int i = 0; i < 3; ++i) guard.Stop();
  for (int i = 0; i < 3; ++i) guard.Fail();
  EXPECT_EQ(guard.counts().stops, 1U);
  EXPECT_EQ(guard.counts().zeroed, 1U);
}

TEST(ForceGuard, CountsSlewedFramesAndTheirShare) {
  ForceGuard guard = Warm();
  EXPECT_EQ(guard.guarded_share(), 0);
  EXPECT_EQ(ForceGuard(DeviceLimits{}).guarded_share(), 0) << "of no frames";
  // 9 N at 2 N a frame: four frames are held back, the fifth arrives
  for (int i = 0; i < 5; ++i) guard.Pass(WrenchOf(9));
  EXPECT_EQ(guard.counts().slewed, 4U);
  EXPECT_EQ(guard.counts().clamped, 0U);
  EXPECT_NEAR(guard.guarded_share(), 4.0 / (5 + ForceGuard::kRampFrames), 1e-12);
}

TEST(ForceGuard, IsRampingAsLongAsEitherRampLasts) {
  ForceGuard guard = Warm();
  EXPECT_EQ(guard.state(), SafetyState::kOn);
  guard.Begin();
  guard.Pass({});
  EXPECT_EQ(guard.state(), SafetyState::kRamping);
  for (int i = 1; i < ForceGuard::kRampFrames; ++i) guard.Pass({});
  EXPECT_EQ(guard.state(), SafetyState::kOn);
  guard.Stop();
  guard.Resume();
  // the long ramp lasts longer than the short one
  for (int i = 1; i < ForceGuard::kLongRampFrames; ++i) guard.Pass({});
  EXPECT_EQ(guard.state(), SafetyState::kRamping);
  guard.Pass({});
  EXPECT_EQ(guard.state(), SafetyState::kOn);
}

TEST(ForceGuard, ResumeWithoutACauseBeginsNoRamp) {
  ForceGuard guard = Warm();
  guard.Resume();
  EXPECT_EQ(guard.state(), SafetyState::kOn);
}

// 2 N and 0.08 N m a frame belong to 12 N and 0.5 N m; half of the limits have half of the steps.
TEST(ForceGuard, StepsAreInProportionToTheLimits) {
  EXPECT_DOUBLE_EQ(ForceGuard::ForceStepOf({12, 0.5}), 2.0);
  EXPECT_DOUBLE_EQ(ForceGuard::ForceStepOf({6, 0.5}), 1.0);
  EXPECT_DOUBLE_EQ(ForceGuard::MomentStepOf({12, 0.5}), 0.08);
  EXPECT_DOUBLE_EQ(ForceGuard::MomentStepOf({12, 0.25}), 0.04);
}

TEST(SafetyCounts, AddUpKindByKind) {
  SafetyCounts sum{1, 2, 3, 4, 5};
  sum += SafetyCounts{10, 20, 30, 40, 50};
  EXPECT_EQ(sum.clamped, 11U);
  EXPECT_EQ(sum.slewed, 22U);
  EXPECT_EQ(sum.zeroed, 33U);
  EXPECT_EQ(sum.expired, 44U);
  EXPECT_EQ(sum.stops, 55U);
}

}  // namespace
}  // namespace tandem
