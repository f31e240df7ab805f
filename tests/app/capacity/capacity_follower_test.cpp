#include "app/capacity/capacity_follower.h"

#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kTests = 200'000;
constexpr double kLookPrice = 500;
constexpr double kBudget = 800e-6;

/// Returns a frame that did so many point tests and exact queries.
StepReport Frame(std::size_t tests, double exact_queries) {
  StepReport report;
  report.tests.looked_up = tests;
  report.query_cost = exact_queries;
  return report;
}

/// Returns the time that such a frame's work was measured to take, s.
double Priced(const StepReport& report) {
  return kBudget * (static_cast<double>(report.tests.looked_up) + kLookPrice * report.query_cost) /
         kTests;
}

TEST(CapacityFollower, SubtractsTheTimeOfLightFrames) {
  CapacityFollower follower(kTests, kLookPrice, kBudget);
  EXPECT_EQ(follower.tests(), kTests);
  for (int frame = 0; frame < 1000; ++frame) follower.Count(Frame(0, 0), 40e-6);
  EXPECT_NEAR(follower.tests(), 0.95 * kTests, 0.001 * kTests);
}

TEST(CapacityFollower, LearnsTheCostOfTestsAndQueries) {
  const StepReport heavy = Frame(20'000, 250);
  for (const double share : {0.5, 1.0, 1.6}) {
    CapacityFollower follower(kTests, kLookPrice, kBudget);
    for (int frame = 0; frame < 1000; ++frame) {
      follower.Count(frame % 2 == 0 ? heavy : Frame(0, 0),
                     30e-6 + (frame % 2 == 0 ? share * Priced(heavy) : 0.0));
    }
    // as many such frames as this takes the whole budget
    const double fits = follower.tests() / kTests * kBudget;
    EXPECT_NEAR(30e-6 + share * fits, kBudget, 0.1 * kBudget) << share;
  }
}

TEST(CapacityFollower, IgnoresAFrameDelayedByTheMachine) {
  const StepReport heavy = Frame(20'000, 250);
  CapacityFollower follower(kTests, kLookPrice, kBudget);
  for (int frame = 0; frame < 500; ++frame) follower.Count(heavy, Priced(heavy));
  const double before = follower.tests();
  follower.Count(heavy, 15e-3);
  EXPECT_GT(follower.tests(), 0.97 * before);
  for (int frame = 0; frame < 500; ++frame) follower.Count(heavy, Priced(heavy));
  follower.Count(Frame(100, 0), 15e-3);
  EXPECT_GT(follower.tests(), 0.97 * before);
}

TEST(CapacityFollower, StaysWithinAFactorOfFour) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> share(0, 1);
  for (int run = 0; run < 100; ++run) {
    CapacityFollower follower(kTests, kLookPrice, kBudget);
    const double slow = run % 3 == 0 ? 0.0 : run % 3 == 1 ? 1e-6 : 1e-2;  // s a frame
    for (int frame = 0; frame < 500; ++frame) {
      follower.Count(Frame(random() % 300'000, 600 * share(random)), slow * share(random));
      ASSERT_GE(follower.tests(), 0.25 * kTests);
      ASSERT_LE(follower.tests(), 4.0 * kTests);
    }
  }
}

}  // namespace
}  // namespace tandem
