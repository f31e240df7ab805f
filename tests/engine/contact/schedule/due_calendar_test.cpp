// The oracle is the way that each item really came.
#include "engine/contact/schedule/due_calendar.h"

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Uniform;

constexpr double kRadius = 100;  // voxels

struct Item {
  double out;    // distance from the origin
  double ahead;  // free way as it was put in
  double came = 0;
  bool in = true;
};

template <int kBucketsPerVoxel>
void ExpectNoneLate() {
  std::mt19937_64 random(1);
  DueCalendar<kBucketsPerVoxel> calendar(500, kRadius);
  std::vector<Item> items;
  for (std::uint32_t i = 0; i < 500; ++i) {
    items.push_back({Uniform(random, 0, 8 * kRadius), Uniform(random, 0, 120)});
    // an item farther out than the body is so far from it at least
    items[i].ahead = std::max(items[i].ahead, items[i].out > 4 * kRadius ? 3 * kRadius : 0.0);
    calendar.Put(i, items[i].out, items[i].ahead, 1);
  }
  std::size_t early = 0;
  std::size_t taken = 0;
  for (int frame = 0; frame < 3000; ++frame) {
    const PairMotion motion{Uniform(random, 0, 0.3), Uniform(random, 0, 0.003)};
    for (Item& item : items) item.came += motion.way + motion.angle * item.out;
    calendar.Advance(motion, 0, [&](std::uint32_t i) {
      items[i].in = false;
    });
    for (std::uint32_t i = 0; i < items.size(); ++i) {
      Item& item = items[i];
      ASSERT_TRUE(!item.in || item.came <= item.ahead) << i << " in frame " << frame;
      if (item.in) continue;
      ++taken;
      early += item.came < 0.5 * item.ahead ? 1 : 0;
      item = {item.out, std::max(Uniform(random, 0, 40), item.out > 4 * kRadius ? 300.0 : 0.0)};
      calendar.Put(i, item.out, item.ahead, 1);
    }
  }
  EXPECT_GT(taken, 5000U);
  EXPECT_LT(early, taken / 2);
}

TEST(DueCalendar, TakesEveryItemBeforeItsDistanceIsTravelled) {
  ExpectNoneLate<8>();
  ExpectNoneLate<1>();
}

// Most of a large scene is farther than the calendar reaches.
TEST(DueCalendar, DistantItemsBecomeDueGradually) {
  constexpr std::uint32_t kItems = 10'000;
  DueCalendar<1> calendar(kItems, kRadius);
  for (std::uint32_t i = 0; i < kItems; ++i) calendar.Put(i, kRadius, 1e4, 1);
  std::size_t most = 0;
  std::size_t taken = 0;
  for (int frame = 0; frame < 2000; ++frame) {
    std::size_t due = 0;
    calendar.Advance({0.5, 0}, 0, [&](std::uint32_t) {
      ++due;
    });
    most = std::max(most, due);
    taken += due;
  }
  EXPECT_EQ(taken, kItems);
  EXPECT_LT(most, kItems / 50);
}

TEST(DueCalendar, LookaheadTakesAllItemsDueWithinIt) {
  std::mt19937_64 random(3);
  DueCalendar<8> calendar(300, kRadius);
  std::vector<double> ahead;
  for (std::uint32_t i = 0; i < 300; ++i) {
    ahead.push_back(Uniform(random, 0, 40));
    calendar.Put(i, Uniform(random, 0, 0.5 * kRadius), ahead.back(), 1);
  }
  std::vector<bool> taken(300);
  calendar.TakeWithin(10, [&](std::uint32_t i) {
    taken[i] = true;
  });
  for (std::uint32_t i = 0; i < 300; ++i) {
    if (ahead[i] < 10) {
      EXPECT_TRUE(taken[i]) << ahead[i];
    } else if (ahead[i] > 10.25) {
      EXPECT_FALSE(taken[i]) << ahead[i];
    }
  }
  EXPECT_GE(calendar.FreeTravel(), 10);
  // an item farther out than the body goes farther
  calendar.Put(0, 3 * kRadius, 30, 1);
  calendar.TakeWithin(10, [](std::uint32_t) {});
  EXPECT_GE(calendar.FreeTravel(), 10);
}

TEST(DueCalendar, ReportsTheCostOfItemsDueWithinADistance) {
  std::mt19937_64 random(4);
  DueCalendar<8> calendar(300, kRadius);
  std::vector<std::uint32_t> costs(300);
  const auto put = [&](std::uint32_t i) {
    costs[i] = static_cast<std::uint32_t>(1 + random() % 100);
    calendar.Put(i, Uniform(random, 0, 2 * kRadius), Uniform(random, 0, 20), costs[i]);
  };
  for (std::uint32_t i = 0; i < 300; ++i) put(i);
  for (int frame = 0; frame < 200; ++frame) {
    // all rings go as far when nothing turns
    const auto ahead = static_cast<std::size_t>(random() % 8);
    const std::uint64_t foretold = calendar.CostWithin(ahead, {1, 0});
    std::uint64_t came = 0;
    std::vector<std::uint32_t> due;
    // to the middle of the last of these buckets, from that of now
    const double middle = frame == 0 ? 0.5 : 0;
    calendar.Advance({(static_cast<double>(ahead) + middle) / 8, 0}, 0, [&](std::uint32_t i) {
      came += costs[i];
      due.push_back(i);
    });
    ASSERT_EQ(came, foretold) << "in frame " << frame;
    std::ranges::for_each(due, put);
    // an item that is put elsewhere counts there only
    put(static_cast<std::uint32_t>(random() % 300));
  }
}

// An item that is farther out than the body's edge goes farther as that turns.
TEST(DueCalendar, RotationMakesNoMoreItemsDueThanPredicted) {
  std::mt19937_64 random(6);
  DueCalendar<8> calendar(300, kRadius);
  const auto put = [&](std::uint32_t i) {
    calendar.Put(i, Uniform(random, 0, 4 * kRadius), Uniform(random, 0, 20), 1);
  };
  for (std::uint32_t i = 0; i < 300; ++i) put(i);
  std::size_t all = 0;
  for (int frame = 0; frame < 200; ++frame) {
    const double way = Uniform(random, 0, 1);  // voxels; way of the body's edge
    const std::uint64_t foretold =
        calendar.CostWithin(static_cast<std::size_t>(8 * way) + 1, {0, 1});
    std::vector<std::uint32_t> due;
    calendar.Advance({0, way / kRadius}, 0, [&](std::uint32_t i) {
      due.push_back(i);
    });
    ASSERT_LE(due.size(), foretold) << "in frame " << frame;
    all += due.size();
    std::ranges::for_each(due, put);
  }
  EXPECT_GT(all, 1000U);
}

TEST(DueCalendar, JumpMakesAllItemsDue) {
  DueCalendar<8> calendar(3, kRadius);
  for (std::uint32_t i = 0; i < 3; ++i) calendar.Put(i, 10.0 * i, 20.0 * i, 1);
  int taken = 0;
  calendar.Advance({std::numeric_limits<double>::infinity(), 0}, 0, [&](std::uint32_t) {
    ++taken;
  });
  EXPECT_EQ(taken, 3);
  EXPECT_EQ(calendar.CostWithin(DueCalendar<8>::kBuckets, {}), 0U);
}

// The rings turn over some ten times. An item is due up to a bucket early. None is so far out that
// it goes farther than the body's edge.
TEST(DueCalendar, FreeDistanceIsThatOfTheFirstDueItem) {
  constexpr std::uint32_t kItems = 12;
  std::mt19937_64 random(5);
  DueCalendar<8> calendar(kItems, kRadius);
  std::vector<double> rest(kItems);
  const auto put = [&](std::uint32_t i) {
    rest[i] = Uniform(random, 0, 60);
    calendar.Put(i, Uniform(random, 0, kRadius - 60), rest[i], 1);
  };
  for (std::uint32_t i = 0; i < kItems; ++i) put(i);
  for (int frame = 0; frame < 3000; ++frame) {
    const double first = *std::ranges::min_element(rest);
    ASSERT_LE(calendar.FreeTravel(), first + 1e-9) << "in frame " << frame;
    ASSERT_GE(calendar.FreeTravel(), first - 1 / DueCalendar<8>::kPerVoxel - 1e-9)
        << "in frame " << frame;
    const double way = Uniform(random, 0, 0.5);
    for (double& r : rest) r -= way;
    std::vector<std::uint32_t> due;
    calendar.Advance({way, 0}, 0, [&](std::uint32_t i) {
      due.push_back(i);
    });
    std::ranges::for_each(due, put);
    if (frame % 7 == 0) {
      // as an item that is not due yet is put elsewhere
      const auto i = static_cast<std::uint32_t>(random() % kItems);
      calendar.Remove(i);
      put(i);
    }
  }
}

TEST(DueCalendar, ReportsTheDistanceWithoutDueItems) {
  DueCalendar<8> calendar(2, kRadius);
  EXPECT_GE(calendar.FreeTravel(), 15.0);
  calendar.Put(0, 50, 6.0, 1);
  EXPECT_LE(calendar.FreeTravel(), 6.0);
  EXPECT_GE(calendar.FreeTravel(), 6.0 - 1 / DueCalendar<8>::kPerVoxel);
  calendar.Remove(0);
  EXPECT_GE(calendar.FreeTravel(), 15.0);
}

}  // namespace
}  // namespace tandem
