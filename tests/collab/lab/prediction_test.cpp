#include "collab/lab/prediction.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

const Inertia kCube{0.3, 8e-5 * Mat3::Identity()};

LabCase Constant(const char* hand, double stiffness, double damping, double delay_s) {
  LabCase test;
  test.hands = {*HandNamed(hand, kCube)};
  test.delay_s = delay_s;
  test.law.name = "constant";
  test.law.limits.constant_stiffness = stiffness;
  test.law.limits.constant_damping = damping;
  return test;
}

TEST(Prediction, OfTwoFreeUsersIsTheExactBoundaryAtTheMeanAge) {
  // body and arm 1.5 kg, 12.3 N s/m with the law's drag; half a gap and half a frame beside 0.3 s
  const std::optional<Prediction> heavy = Predict(Constant("heavy", 60, 10, 0.3), kCube);
  ASSERT_TRUE(heavy);
  EXPECT_DOUBLE_EQ(heavy->stiffness, 60);
  EXPECT_NEAR(heavy->critical, CriticalStiffness(0.301, 12.3, 1.5), 1e-3);
  EXPECT_TRUE(heavy->is_stable());
  EXPECT_FALSE(Predict(Constant("heavy", 75, 10, 0.3), kCube)->is_stable());
  // the control: no drag but the device's
  EXPECT_FALSE(Predict(Constant("off", 200, 0, 0.1), kCube)->is_stable());
}

TEST(Prediction, CountsJitterLossAndRateIntoTheAge) {
  LabCase test = Constant("heavy", 60, 10, 0.3);
  test.publish_hz = 100;
  EXPECT_NEAR(MeanAge(test), 0.3 + 0.005 + 0.0005, 1e-12);
  test.network.there.jitter_ms = test.network.back.jitter_ms = 30;
  EXPECT_NEAR(MeanAge(test), 0.3 + 0.015 + 0.005 + 0.0005, 1e-12);
  test.network.there.loss = test.network.back.loss = 0.5;
  EXPECT_NEAR(MeanAge(test), 0.3 + 0.015 + 0.010 + 0.0005, 1e-12);
  test.network.skew = 0.8;  // the loop is as long
  EXPECT_NEAR(MeanAge(test), 0.3 + 0.015 + 0.010 + 0.0005, 1e-12);
}

TEST(Prediction, CountsAllLinksOfAUserAndTheWorstHand) {
  LabCase test = Constant("heavy", 60, 10, 0.3);
  test.users = 4;
  // "constant" divides among the links: as stiff in sum
  EXPECT_NEAR(Predict(test, kCube)->stiffness, 60, 1e-9);
  EXPECT_GE(Predict(test, kCube)->critical,
            Predict(Constant("heavy", 60, 10, 0.3), kCube)->critical * (1 - 1e-6));
  LabCase mixed = Constant("relaxed", 60, 10, 0.3);
  const double relaxed = Predict(mixed, kCube)->critical;
  mixed.hands.push_back(*HandNamed("heavy", kCube));
  EXPECT_LT(Predict(mixed, kCube)->critical, relaxed);
}

TEST(Prediction, InContactIsWhatIsPassive) {
  LabCase test = Constant("heavy", 30, 10, 0.3);
  test.scene = "slot";
  EXPECT_NEAR(Predict(test, kCube)->critical, 12.3 / 0.301, 1e-9);
}

TEST(Prediction, IsNotMadeWhereTheEquationDoesNotHold) {
  LabCase test = Constant("heavy", 60, 10, 0.3);
  test.law.exchange_forces = true;
  EXPECT_FALSE(Predict(test, kCube));
  test.law.exchange_forces = false;
  test.network.schedule.push_back({1, 0.3, false});
  EXPECT_FALSE(Predict(test, kCube));
}

TEST(Prediction, OfTheDefaultLawIsStableAtEveryDelayAndHand) {
  for (const char* const hand : {"off", "relaxed", "heavy", "firm"}) {
    for (const double delay_s : {0.02, 0.1, 0.3, 1.0}) {
      LabCase test;
      test.hands = {*HandNamed(hand, kCube)};
      test.delay_s = delay_s;
      const std::optional<Prediction> predicted = Predict(test, kCube);
      ASSERT_TRUE(predicted);
      EXPECT_TRUE(predicted->is_stable()) << hand << " " << delay_s << ": " << predicted->stiffness
                                          << " of " << predicted->critical;
    }
  }
}

}  // namespace
}  // namespace tandem
