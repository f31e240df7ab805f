// Each test breaks a rule and measures what the motor gets.
#include "engine/safety/motor_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kTick = 1'000'000;  // ns

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

TEST(MotorGuard, GivesNothingUntilARampInIsAskedFor) {
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

TEST(MotorGuard, ClampsToTheDevicesLimitsAndToWhatAHandMayHave) {
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

TEST(MotorGuard, ALimitThatIsNoneIsZero) {
  for (const double claimed : {0.0, -3.0, kNoNumber, std::numeric_limits<double>::infinity()}) {
    Rig rig({.limits = {claimed, claimed}, .continuous = {5, 0.5}});
    ++rig.order.ramps;
    rig.Ticks(1200);
    EXPECT_EQ(rig.most, 0);
    EXPECT_EQ(rig.most_moment, 0);
  }
}

TEST(MotorGuard, NothingFreshForFiveMillisecondsLeavesDampingAndForTwentyNothing) {
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
TEST(MotorGuard, TheLargestForceIsGoneInTimeByItsSlewAlone) {
  Rig rig({.limits = {30, 1}, .continuous = {30, 1}});
  rig.order.F_D_W = {Vec3(0, 1, 0), Vec3(30, 0, 0)};
  rig.Begin();
  for (int age = 1; age <= 19; ++age) rig.Tick(false);
  EXPECT_TRUE(rig.Nothing());
  rig.ExpectWithinLimits(30, 1);
}

TEST(MotorGuard, AFewLateOrdersEndInAShortRamp) {
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
TEST(MotorGuard, ALateOrderDoesNotShortenTheRampInThatIsUnderWay) {
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
TEST(MotorGuard, ManyLateOrdersDoNotShortenTheRampInEither) {
  Rig rig;
  ++rig.order.ramps;
  rig.Ticks(10);
  for (int i = 0; i < 20; ++i) {
    rig.Ticks(6, false);
    rig.Ticks(20);
    EXPECT_LE(rig.given.f.x(), 5e-3 * (10 + 25 * (i + 1))) << i;
  }
}

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
TEST(MotorGuard, OfTwoCausesTheGraverOneHolds) {
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
TEST(MotorGuard, ADriverThatFailsAfterItHungNeedsAPerson) {
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

TEST(MotorGuard, BeforeTheFirstOrderItIsOffAndNotLate) {
  Rig rig;
  rig.Ticks(100, false);
  EXPECT_EQ(rig.guard.state(), SafetyState::kOff);
  EXPECT_EQ(rig.guard.counts().zeroed, 0U);
}

TEST(MotorGuard, WhatIsNoNumberEndsTheForceUntilAPersonResumes) {
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

TEST(MotorGuard, ARampInIsNotGivenWhileTheCauseLasts) {
  Rig rig;
  rig.Begin();
  rig.input.failed = true;
  rig.Tick();
  ++rig.order.ramps;
  rig.Ticks(100);
  EXPECT_EQ(rig.guard.state(), SafetyState::kFault);
  EXPECT_TRUE(rig.Nothing());
}

TEST(MotorGuard, AHandFasterThanHandsAreGetsNothingUntilItIsSlowAgain) {
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
TEST(MotorGuard, AFastHandMustBeSlowAgainWhateverEndsItsForceMeanwhile) {
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

// A late order must not have all of the damping in a tenth of a second's ramp-in.
TEST(MotorGuard, DampingOfALateOrderGrowsAsTheRampInDoes) {
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

// The driver says that the handle rests, while it goes at 1.5 m/s.
TEST(MotorGuard, ADriversOwnSpeedIsNotTrusted) {
  Rig rig;
  rig.Begin();
  for (int i = 0; i < 30; ++i) {
    rig.input.p_WD.x() += 1.5e-3;
    rig.Tick();
  }
  EXPECT_EQ(rig.guard.state(), SafetyState::kTooFast);
  EXPECT_TRUE(rig.Nothing());
}

TEST(MotorGuard, AnEmergencyStopHoldsUntilSomebodyResumes) {
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

TEST(MotorGuard, NobodyResumesWhileTheButtonIsDownOrTheProcessEnds) {
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

TEST(MotorGuard, ALoopThatStoodStillGivesNothingUntilARampIn) {
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

TEST(MotorGuard, AMachineThatSleptGivesNothingUntilARampIn) {
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
TEST(MotorGuard, TheControllerPaysAnActivePortsDebtBack) {
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
TEST(MotorGuard, NothingPasses) {
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
