#include "engine/realtime/histogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

constexpr std::array kQuantiles = {0.0, 0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0};

// Returns the least value that at least a share q of all does not exceed.
std::int64_t ExactQuantile(const std::vector<std::int64_t>& sorted, double q) {
  const double rank = std::ceil(q * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

TEST(Histogram, QuantilesMatchASortWithinTwoPercent) {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> microseconds(std::log(40e3), 2.0);
  std::uniform_int_distribution<std::int64_t> anything(0, std::numeric_limits<std::int64_t>::max());
  std::vector<std::int64_t> values;
  values.reserve(101'000);
  for (int i = 0; i < 100'000; ++i) values.push_back(std::llround(microseconds(random)));
  for (int i = 0; i < 1000; ++i) values.push_back(anything(random) >> (i % 63));

  Histogram histogram;
  for (const std::int64_t value : values) histogram.Add(value);
  std::sort(values.begin(), values.end());

  ASSERT_EQ(histogram.count(), values.size());
  EXPECT_EQ(histogram.max(), values.back());
  for (const double q : kQuantiles) {
    const auto exact = static_cast<double>(ExactQuantile(values, q));
    EXPECT_NEAR(static_cast<double>(histogram.Quantile(q)), exact, 0.02 * exact) << "q = " << q;
  }
}

TEST(Histogram, EveryPowerOfTwoAndItsNeighboursAreWithinTwoPercent) {
  for (int bit = 0; bit < 63; ++bit) {
    for (const std::int64_t offset : {-1, 0, 1}) {
      const std::int64_t value = (std::int64_t{1} << bit) + offset;
      Histogram histogram;
      histogram.Add(value);
      histogram.Add(std::numeric_limits<std::int64_t>::max());
      EXPECT_NEAR(static_cast<double>(histogram.Quantile(0.5)), static_cast<double>(value),
                  0.02 * static_cast<double>(value));
    }
  }
}

TEST(Histogram, SmallValuesAreExact) {
  for (std::int64_t value = 0; value < 64; ++value) {
    Histogram histogram;
    histogram.Add(value);
    histogram.Add(1000);
    EXPECT_EQ(histogram.Quantile(0.5), value);
  }
}

TEST(Histogram, EmptyGivesZeroAndNegativeCountsAsZero) {
  Histogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.Quantile(0.5), 0);
  EXPECT_EQ(histogram.max(), 0);
  histogram.Add(-5);
  EXPECT_EQ(histogram.count(), 1U);
  EXPECT_EQ(histogram.Quantile(1.0), 0);
}

TEST(Histogram, AddingAllocatesNothing) {
  Histogram histogram;
  const testing::AllocationCounter allocations;
  for (std::int64_t value = 1; value > 0 && value < (std::int64_t{1} << 60); value *= 3) {
    histogram.Add(value);
  }
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_GT(histogram.count(), 30U);
}

}  // namespace
}  // namespace tandem
