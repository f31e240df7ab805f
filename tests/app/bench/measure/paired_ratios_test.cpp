#include "app/bench/measure/paired_ratios.h"

#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(PairedRatios, MedianOfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(MedianOf({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(MedianOf({9, 1, 3}), 3);
}

TEST(PairedRatios, BaseIsTheMeanOfTheRunsBeforeAndAfter) {
  const PairedRatios ratios = RatiosToBase({60, 66, 90}, {40, 60, 50}, {80, 60, 70});
  EXPECT_DOUBLE_EQ(ratios.median, 1.1);
  EXPECT_DOUBLE_EQ(ratios.least, 1.0);
  EXPECT_DOUBLE_EQ(ratios.most, 1.5);
}

// The machine grows slower by half while it measures. Each round is compared with itself.
TEST(PairedRatios, MachineDriftIsNotCounted) {
  std::vector<double> before;
  std::vector<double> watched;
  std::vector<double> after;
  for (int round = 0; round < 5; ++round) {
    const double machine = 40 * (1 + 0.1 * round);
    before.push_back(machine);
    watched.push_back(1.2 * (machine + 1));
    after.push_back(machine + 2);
  }
  const PairedRatios ratios = RatiosToBase(watched, before, after);
  EXPECT_NEAR(ratios.least, 1.2, 1e-12);
  EXPECT_NEAR(ratios.most, 1.2, 1e-12);
}

// Viewers that cost a fifth cost a fifth however noisy the runs are. Divided by the ratio of the
// two runs without viewers, they would cost less the more these runs differ.
TEST(PairedRatios, NoiseDoesNotImproveTheMedian) {
  std::mt19937_64 random(3);
  double widest = 0;
  for (const double noise : {0.0, 0.1, 0.3}) {
    std::uniform_real_distribution<double> times(1 - noise, 1 + noise);
    std::vector<double> before;
    std::vector<double> watched;
    std::vector<double> after;
    for (int round = 0; round < 999; ++round) {
      before.push_back(50 * times(random));
      watched.push_back(60 * times(random));
      after.push_back(50 * times(random));
    }
    const PairedRatios ratios = RatiosToBase(watched, before, after);
    EXPECT_NEAR(ratios.median, 1.2, 0.03) << noise;
    EXPECT_GE(ratios.most - ratios.least, widest);
    widest = ratios.most - ratios.least;
  }
  EXPECT_GT(widest, 0.5);
}

TEST(PairedRatios, EqualsDifferByNoiseAlone) {
  EXPECT_DOUBLE_EQ(RatioOfEquals({40, 60, 50}, {80, 60, 40}), 1.25);
}

}  // namespace
}  // namespace tandem
