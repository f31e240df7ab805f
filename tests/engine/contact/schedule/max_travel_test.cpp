#include "engine/contact/schedule/max_travel.h"

#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kFineVoxel = 0.001;
constexpr double kBound = 0.5 * kFineVoxel;
constexpr double kFloor = kTravelFloor * kFineVoxel;
constexpr double kPrice = 400;
constexpr double kCapacity = 1e5;

/// Returns the tests and exact queries of a frame that goes so far, in tests.
double Cost(const TestDemand& demand, double travel) {
  return demand.mandatory + demand.per_metre * travel + kPrice * demand.exact_queries;
}

TestDemand SomeDemand(std::mt19937_64& random, double most_looks) {
  std::uniform_real_distribution<double> share(0, 1);
  TestDemand demand;
  demand.bound = kBound;
  demand.mandatory = 0.6 * kCapacity * share(random);
  demand.per_metre = 4 * kCapacity * share(random) / kBound;
  demand.exact_queries = most_looks * share(random);
  return demand;
}

// Tests owed, tests due and exact queries share one frame: what they come to at the limit fills it.
TEST(MaxTravel, UsesTheWholeFrameBudget) {
  std::mt19937_64 random(11);
  int limited = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const TestDemand demand = SomeDemand(random, 0.25 * kCapacity / kPrice);
    const double travel = MaxTravel(demand, kCapacity, kPrice, kFineVoxel);
    if (travel == kBound) {
      EXPECT_LE(Cost(demand, travel), kCapacity * (1 + 1e-9));
    } else if (Cost(demand, 0) < kCapacity - kTravelShare * (kCapacity - demand.mandatory)) {
      EXPECT_NEAR(Cost(demand, travel), kCapacity, 1e-6 * kCapacity);
      ++limited;
    }
  }
  EXPECT_GT(limited, 300);
}

// Queries are no fewer at a slower pace: however many, they never take the last two fifths of what
// tests have, so a heavy contact is not slowed for nothing.
TEST(MaxTravel, ReservesTestsForTravelBesideQueries) {
  std::mt19937_64 random(12);
  for (int trial = 0; trial < 1000; ++trial) {
    const TestDemand demand = SomeDemand(random, 100 * kCapacity / kPrice);
    const double travel = MaxTravel(demand, kCapacity, kPrice, kFineVoxel);
    const double least = kTravelShare * (kCapacity - demand.mandatory) / demand.per_metre;
    EXPECT_GE(travel, std::min(kBound, least) * (1 - 1e-9));
    EXPECT_LE(travel, kBound);
    TestDemand more = demand;
    more.exact_queries += 10;
    EXPECT_LE(MaxTravel(more, kCapacity, kPrice, kFineVoxel), travel);
  }
}

TEST(MaxTravel, KeepsAMinimumUnderTooManyTests) {
  TestDemand demand;
  demand.bound = kBound;
  demand.mandatory = 2 * kCapacity;
  EXPECT_EQ(MaxTravel(demand, kCapacity, kPrice, kFineVoxel), kFloor);
  demand.mandatory = 0;
  demand.per_metre = 1e6 * kCapacity / kBound;
  EXPECT_EQ(MaxTravel(demand, kCapacity, kPrice, kFineVoxel), kFloor);
  demand.per_metre = 0;
  EXPECT_EQ(MaxTravel(demand, kCapacity, kPrice, kFineVoxel), kBound);
}

TEST(MaxTravel, IsBoundedByTheSumOverAllPairs) {
  std::mt19937_64 random(13);
  for (int trial = 0; trial < 100; ++trial) {
    const TestDemand one = SomeDemand(random, 50);
    TestDemand sum = one;
    TestDemand other = SomeDemand(random, 50);
    other.bound = 0.5 * kBound;
    sum += other;
    EXPECT_EQ(sum.bound, 0.5 * kBound);
    EXPECT_LE(MaxTravel(sum, kCapacity, kPrice, kFineVoxel),
              MaxTravel(one, kCapacity, kPrice, kFineVoxel));
  }
}

}  // namespace
}  // namespace tandem
