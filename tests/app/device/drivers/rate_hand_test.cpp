#include "app/device/drivers/rate_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem::driver {
namespace {

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

TEST(RateHandTest, MovesAtTheRateAndRotatesAboutTheAxis) {
  RateHand hand;
  for (int i = 0; i <= 1000; ++i) hand.Move(Vec3(0.1, 0, 0), Vec3(0, M_PI / 2, 0), i * kMs);
  EXPECT_NEAR(PlaceOf(hand).x(), 0.1, 1e-12);
  TandemDeviceState state{};
  hand.Tell(state);
  EXPECT_NEAR(state.orientation[1], std::sin(M_PI / 4), 1e-9);
  EXPECT_NEAR(state.orientation[3], std::cos(M_PI / 4), 1e-9);
  EXPECT_EQ(state.velocity[0], 0.1);
}

TEST(RateHandTest, TimeOfAStalledLoopIsSkipped) {
  RateHand hand;
  hand.Move(Vec3(0.5, 0, 0), Vec3::Zero(), 0);
  hand.Move(Vec3(0.5, 0, 0), Vec3::Zero(), 3000 * kMs);
  EXPECT_NEAR(PlaceOf(hand).x(), 0.5 * RateHand::kLongestStep, 1e-12);
  hand.Move(Vec3(0.5, 0, 0), Vec3::Zero(), 2000 * kMs);  // time that goes back is none
  EXPECT_NEAR(PlaceOf(hand).x(), 0.5 * RateHand::kLongestStep, 1e-12);
}

TEST(RateHandTest, InvalidForcesAndSpeedsMoveNothing) {
  RateHand hand;
  hand.Feel(ForceAlongX(std::numeric_limits<double>::quiet_NaN()));
  for (int i = 0; i <= 100; ++i) hand.Move(Vec3(99, 0, 0), Vec3::Zero(), i * kMs);
  EXPECT_NEAR(PlaceOf(hand).x(), 0.1 * RateHand::kMostSpeed, 1e-12);
}

/// A part that contact holds at 0, and a coupling from it to the handle, whose force the handle
/// hears a tick later as its guard lets it through.
class HeldPart {
 public:
  HeldPart(double stiffness, double damping) : stiffness_(stiffness), damping_(damping) {}

  void Go(double rate, int ticks) {
    constexpr double kUsersLimit = 3;  // N
    constexpr double kSlew = 0.5;      // N a tick
    fastest_ = 0;
    for (int i = 0; i < ticks; ++i) {
      hand_.Feel(ForceAlongX(felt_));
      hand_.Move(Vec3(rate, 0, 0), Vec3::Zero(), now_ns_ += kMs);
      TandemDeviceState state{};
      hand_.Tell(state);
      lead_ = state.position[0];
      const double wanted =
          std::clamp(-stiffness_ * lead_ - damping_ * state.velocity[0], -kUsersLimit, kUsersLimit);
      felt_ += std::clamp(wanted - felt_, -kSlew, kSlew);
      if (i > ticks / 2) fastest_ = std::max(fastest_, std::abs(state.velocity[0]));
    }
  }
  double lead() const { return lead_; }        // m; distance of the handle ahead of the part
  double force() const { return -felt_; }      // N
  double fastest() const { return fastest_; }  // m/s; largest speed in the second half of Go()

 private:
  RateHand hand_;
  double stiffness_;
  double damping_;
  double felt_ = 0;
  double lead_ = 0;
  double fastest_ = 0;
  std::int64_t now_ns_ = 0;
};

TEST(RateHandTest, HandleRestsAtABlockedPart) {
  for (const double stiffness : {200.0, 800.0, 2000.0, 3000.0}) {
    for (const double damping : {0.0, 2.0, 8.0, 16.0, 30.0}) {
      for (const double rate : {0.02, 0.1, 0.5}) {
        HeldPart part(stiffness, damping);
        part.Go(rate, 4000);
        EXPECT_LT(part.fastest(), 1e-4) << stiffness << " " << damping << " " << rate;
        EXPECT_GT(part.force(), RateHand::kFreeForce);
        EXPECT_LT(part.force(), RateHand::kFullForce);
        EXPECT_LT(part.lead(), RateHand::kFullForce / stiffness);
      }
    }
  }
}

TEST(RateHandTest, HandleReversesAtOnce) {
  HeldPart part(800, 8);
  part.Go(0.1, 4000);
  ASSERT_GT(part.lead(), 0.001);
  // the handle is at most 2.5 mm ahead, which is gone in as many hundredths of a second, and a few
  // more for the damper
  part.Go(-0.1, 50);
  EXPECT_LT(part.lead(), 0);
}

TEST(RateHandTest, HandSlidesAlongAWallAsCommanded) {
  RateHand hand;
  hand.Feel(ForceAlongX(-2.5));
  for (int i = 0; i <= 1000; ++i) hand.Move(Vec3(0.1, 0.1, 0), Vec3::Zero(), i * kMs);
  TandemDeviceState state{};
  hand.Tell(state);
  EXPECT_NEAR(state.velocity[1], 0.1, 1e-12);
  // the hand does not go into the wall, and the force moves it slowly out of it
  EXPECT_NEAR(state.velocity[0], -1.5 * RateHand::kYield, 1e-6);
}

TEST(RateHandTest, DistanceIsCoveredSoonAndCompletely) {
  RateHand hand;
  hand.Move(Vec3::Zero(), Vec3::Zero(), 0);
  hand.Add(Vec3(0.005, 0, 0), Vec3(0, 0.2, 0));
  for (int i = 1; i <= 200; ++i) hand.Move(Vec3::Zero(), Vec3::Zero(), i * kMs);
  EXPECT_NEAR(PlaceOf(hand).x(), 0.005, 1e-9);
  TandemDeviceState state{};
  hand.Tell(state);
  EXPECT_NEAR(state.orientation[1], std::sin(0.1), 1e-7);
}

}  // namespace
}  // namespace tandem::driver
