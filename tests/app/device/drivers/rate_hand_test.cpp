#include "app/device/drivers/rate_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tandem::driver {
namespace {

constexpr std::int64_t kMs = 1'000'000;

Vec3 PlaceOf(const RateHand& hand) {
  TandemDeviceState state{};
  hand.Tell(state);
  return Vec3(state.position);
}

TandemDeviceForce ForceAlongX(double force_N) {
  TandemDeviceForce force{};
  force.force[0] = force_N;
  return force;
}

TEST(RateHandTest, GoesAtTheRateAndTurnsAboutTheAxis) {
  RateHand hand;
  for (int i = 0; i <= 1000; ++i) hand.Move(Vec3(0.1, 0, 0), Vec3(0, M_PI / 2, 0), i * kMs);
  EXPECT_NEAR(PlaceOf(hand).x(), 0.1, 1e-12);
  TandemDeviceState state{};
  hand.Tell(state);
  EXPECT_NEAR(state.orientation[1], std::sin(M_PI / 4), 1e-9);
  EXPECT_NEAR(state.orientation[3], std::cos(M_PI / 4), 1e-9);
  EXPECT_EQ(state.velocity[0], 0.1);
}

TEST(RateHandTest, WhatALoopThatStoodStillMissedIsLeftOut) {
  RateHand hand;
  hand.Move(Vec3(0.5, 0, 0), Vec3::Zero(), 0);
  hand.Move(Vec3(0.5, 0, 0), Vec3::Zero(), 3000 * kMs);
  EXPECT_NEAR(PlaceOf(hand).x(), 0.5 * RateHand::kLongestStep, 1e-12);
  hand.Move(Vec3(0.5, 0, 0), Vec3::Zero(), 2000 * kMs);  // time that goes back is none
  EXPECT_NEAR(PlaceOf(hand).x(), 0.5 * RateHand::kLongestStep, 1e-12);
}

TEST(RateHandTest, ForcesThatAreNoNumbersAndSpeedsBeyondBoundsMoveNothing) {
  RateHand hand;
  hand.Feel(ForceAlongX(std::numeric_limits<double>::quiet_NaN()));
  for (int i = 0; i <= 100; ++i) hand.Move(Vec3(99, 0, 0), Vec3::Zero(), i * kMs);
  EXPECT_NEAR(PlaceOf(hand).x(), 0.1 * RateHand::kMostSpeed, 1e-12);
}

/// A part that contact holds at 0, and a coupling of k N/m from it to the handle, whose force the
/// handle hears a tick later, as much as the user's limit lets through.
double LeadAfter(RateHand& hand, double k, double rate, int ticks, double& widest, int from = 0) {
  constexpr double kUsersLimit = 3;  // N
  double felt = 0;
  widest = 0;
  for (int i = from; i < from + ticks; ++i) {
    hand.Feel(ForceAlongX(felt));
    hand.Move(Vec3(rate, 0, 0), Vec3::Zero(), i * kMs);
    const double x = PlaceOf(hand).x();
    felt = std::clamp(-k * x, -kUsersLimit, kUsersLimit);
    if (i - from > ticks / 2) widest = std::max(widest, std::abs(x));
  }
  return PlaceOf(hand).x();
}

TEST(RateHandTest, TheHandleDoesNotRunAheadOfAPartThatContactHolds) {
  for (const double k : {200.0, 800.0, 2000.0, 3000.0}) {
    RateHand hand;
    double widest = 0;
    const double lead = LeadAfter(hand, k, 0.2, 3000, widest);
    // where the yield is as fast as the rate, and it is at rest there
    const double expected = (RateHand::kFreeForce + 0.2 / RateHand::kYield) / k;
    EXPECT_NEAR(lead, expected, 1e-6) << k;
    EXPECT_NEAR(widest, expected, 1e-6) << k;
    // the user turns back: the handle leaves at once
    double back = 0;
    EXPECT_LT(LeadAfter(hand, k, -0.2, 60, back, 3000), 0.5 * expected + 1e-3) << k;
  }
}

}  // namespace
}  // namespace tandem::driver
