// The price of exact looks in MaxTravel (paper §5, Eqn. 2): points that come due after so much
// travel each, at most once a frame, in place of a scene.
#include "engine/contact/look_load.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/contact/max_travel.h"

namespace tandem {
namespace {

constexpr double kVoxel = 0.001;
constexpr double kBound = 0.5 * kVoxel;
constexpr double kPrice = 400;
constexpr double kCapacity = 1e5;

/// Points that are looked at in every frame, and others each after its own way.
struct Points {
  double owed = 0;
  std::vector<double> ways;  // m

  double Due(double travel) const {
    double due = 0;
    for (const double way : ways) due += std::min(1.0, travel / way);
    return due;
  }
  double Cost(double travel) const { return kPrice * (owed + Due(travel)); }
  /// The travel at which a frame just fits.
  double Affordable() const {
    double low = 0;
    double high = kBound;
    if (Cost(high) <= kCapacity) return high;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (Cost(middle) <= kCapacity ? low : high) = middle;
    }
    return low;
  }
};

Points SomePoints(std::size_t count, double owed, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> way(0.02 * kVoxel, 0.5 * kVoxel);
  Points points{owed, {}};
  for (std::size_t i = 0; i < count; ++i) points.ways.push_back(way(random));
  return points;
}

double Limit(const LookLoad& looks) {
  TestLoad load;
  load.bound = kBound;
  load.looks = looks.owed();
  load.looks_per_metre = looks.PerMetre(kTravelFloor * kVoxel);
  load.most_looks = looks.most();
  return MaxTravel(load, kCapacity, kPrice, kVoxel);
}

// A hand that goes as fast as it may: the limit comes down to what fits, from above, and stays.
TEST(LookLoad, ComesToRestWhereAFrameJustFits) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Points points = SomePoints(300 + 40 * seed, 5.0 * static_cast<double>(seed), seed);
    const double fits = points.Affordable();
    ASSERT_LT(fits, kBound);
    ASSERT_GT(fits, kTravelFloor * kVoxel);
    LookLoad looks;
    double travel = kBound;
    for (int frame = 0; frame < 2000; ++frame) {
      looks.Count(points.owed, points.Due(travel), travel);
      const double next = Limit(looks);
      // never up again: it does not swing
      EXPECT_LE(next, travel * (1 + 1e-9)) << "seed " << seed << " frame " << frame;
      travel = next;
    }
    EXPECT_NEAR(travel / fits, 1.0, 0.01) << "seed " << seed;
    EXPECT_LT(points.Cost(travel), 1.01 * kCapacity) << "seed " << seed;
  }
}

// The same hand from rest, gaining speed slowly.
TEST(LookLoad, LetsAHandGoFasterUntilAFrameJustFits) {
  const Points points = SomePoints(800, 20, 7);
  const double fits = points.Affordable();
  LookLoad looks;
  double travel = 0;
  double most = 0;
  for (int frame = 0; frame < 4000; ++frame) {
    looks.Count(points.owed, points.Due(travel), travel);
    travel = std::min(travel + 1e-3 * kBound, Limit(looks));
    most = std::max(most, travel);
  }
  EXPECT_NEAR(travel / fits, 1.0, 0.01);
  EXPECT_LT(most / fits, 1.1);
}

TEST(LookLoad, LeavesAHandAloneWhoseLooksAreFew) {
  const Points points = SomePoints(60, 5, 3);
  LookLoad looks;
  for (const double travel : {0.0, 0.01 * kBound, 0.1 * kBound, kBound}) {
    for (int frame = 0; frame < 100; ++frame) {
      looks.Count(points.owed, points.Due(travel), travel);
      EXPECT_EQ(Limit(looks), kBound) << travel;
    }
  }
}

// What a throw made due is soon forgotten, by a body at rest too.
TEST(LookLoad, ForgetsABurst) {
  LookLoad looks;
  looks.Count(0, 3000, kBound);
  EXPECT_LT(Limit(looks), kBound);
  for (int frame = 0; frame < 100; ++frame) looks.Count(0, 0, 0);
  EXPECT_EQ(Limit(looks), kBound);
}

TEST(LookLoad, CountsNoTravelFromWhereNobodyKnows) {
  LookLoad looks;
  looks.Count(0, 100, std::numeric_limits<double>::infinity());
  EXPECT_EQ(looks.PerMetre(1), 0);
  looks.Count(0, 100, kBound);
  EXPECT_NEAR(looks.PerMetre(1e-9), 100 / kBound, 1e-6 * 100 / kBound);
}

TEST(MaxTravel, IsTheFloorWhereLooksOwedFillTheFrame) {
  TestLoad load;
  load.bound = kBound;
  load.looks = kCapacity / kPrice;
  EXPECT_EQ(MaxTravel(load, kCapacity, kPrice, kVoxel), kTravelFloor * kVoxel);
  load.looks = 0.5 * kCapacity / kPrice;
  EXPECT_EQ(MaxTravel(load, kCapacity, kPrice, kVoxel), kBound);
}

// Looks owed, looks due and tests share one frame: what they come to at the limit fills it.
TEST(MaxTravel, FillsTheFrame) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  for (int trial = 0; trial < 1000; ++trial) {
    TestLoad load;
    load.bound = kBound;
    load.mandatory = 0.3 * kCapacity * share(random);
    load.per_metre = 2 * kCapacity * share(random) / kBound;
    load.looks = 0.3 * kCapacity / kPrice * share(random);
    load.looks_per_metre = 4 * kCapacity / kPrice * share(random) / kBound;
    load.most_looks = kCapacity / kPrice * share(random);
    const double travel = MaxTravel(load, kCapacity, kPrice, kVoxel);
    const double due = std::min(load.looks_per_metre * travel, load.most_looks);
    const double cost = load.mandatory + load.per_metre * travel + kPrice * (load.looks + due);
    if (travel == kBound) {
      EXPECT_LE(cost, kCapacity * (1 + 1e-9));
    } else if (travel > kTravelFloor * kVoxel) {
      EXPECT_NEAR(cost, kCapacity, 1e-6 * kCapacity);
    }
  }
}

}  // namespace
}  // namespace tandem
