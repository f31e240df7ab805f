#include "engine/safety/mean_limit.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

/// Returns the largest mean over any ten seconds of forces of a millisecond each.
double LargestMean(const std::vector<double>& forces) {
  constexpr std::size_t kWindow = 10'000;
  double sum = 0;
  double largest = 0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    sum += forces[i] - (i >= kWindow ? forces[i - kWindow] : 0);
    largest = std::max(largest, sum / kWindow);
  }
  return largest;
}

TEST(MeanLimit, TheMeanOfAnyTenSecondsStaysWithinTheContinuousForce) {
  std::mt19937 random(7);
  for (int run = 0; run < 10; ++run) {
    MeanLimit limit(0.88, 3.3);
    std::vector<double> given;
    double wanted = 3.3;
    for (int i = 0; i < 60'000; ++i) {
      if (run > 0 && random() % 3000 == 0) wanted = 3.3 * static_cast<double>(random() % 3) / 2;
      given.push_back(std::min(wanted, limit.Allowed()));
      limit.RecordForce(given.back(), kMs);
    }
    EXPECT_LE(LargestMean(given), 0.88 + 1e-9) << run;
    // a force that is always wanted gets nearly all that the motor bears
    if (run == 0) {
      EXPECT_GE(LargestMean(given), 0.9 * 0.88);
    }
  }
}

TEST(MeanLimit, LimitsGradually) {
  MeanLimit limit(2, 10);
  double last = limit.Allowed();
  EXPECT_EQ(last, 10);
  for (int i = 0; i < 30'000; ++i) {
    limit.RecordForce(limit.Allowed(), kMs);
    EXPECT_LE(std::abs(limit.Allowed() - last), 0.5) << i;
    last = limit.Allowed();
  }
}

TEST(MeanLimit, ContinuousPeakForceIsNotLimited) {
  MeanLimit limit(5, 5);
  for (int i = 0; i < 30'000; ++i) limit.RecordForce(5, kMs);
  EXPECT_EQ(limit.Allowed(), 5);
}

TEST(MeanLimit, WithoutAContinuousForceItIsZero) {
  EXPECT_EQ(MeanLimit(0, 5).Allowed(), 0);
}

}  // namespace
}  // namespace tandem
