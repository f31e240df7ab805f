#include "collab/receive/link_conditioner.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

// Returns when the only copy of a sample is due, or nothing: lost.
std::optional<std::int64_t> DueOf(LinkConditioner& link, std::int64_t arrival_ns) {
  std::array<std::int64_t, 2> due_ns{};
  const std::size_t copies = link.Due(arrival_ns, due_ns);
  EXPECT_LE(copies, 1U);
  if (copies == 0) return std::nullopt;
  return due_ns[0];
}

TEST(LinkConditioner, AddsExactlyTheDelay) {
  LinkConditioner link({.delay_ms = 100});
  for (std::int64_t t = 0; t < 100; ++t) EXPECT_EQ(DueOf(link, t * kMs), (t + 100) * kMs);
}

TEST(LinkConditioner, KeepsOrderWithinTheJitter) {
  LinkConditioner link({.delay_ms = 50, .jitter_ms = 20, .seed = 3});
  std::int64_t last = 0;
  std::int64_t least = INT64_MAX;
  std::int64_t most = 0;
  for (std::int64_t t = 0; t < 5000; ++t) {
    // samples come ten milliseconds apart, so that order seldom binds
    const std::int64_t due = *DueOf(link, t * 10 * kMs);
    EXPECT_GE(due, last);
    last = due;
    least = std::min(least, due - t * 10 * kMs);
    most = std::max(most, due - t * 10 * kMs);
  }
  EXPECT_GE(least, 50 * kMs);
  EXPECT_LT(least, 51 * kMs);
  EXPECT_LE(most, 70 * kMs);
  EXPECT_GT(most, 69 * kMs);
}

TEST(LinkConditioner, LosesTheRequestedShare) {
  LinkConditioner link({.delay_ms = 10, .loss = 0.05, .seed = 5});
  int lost = 0;
  for (std::int64_t t = 0; t < 20000; ++t) lost += DueOf(link, t * kMs) ? 0 : 1;
  EXPECT_NEAR(lost, 1000, 5 * std::sqrt(950.0));  // five standard deviations
}

TEST(LinkConditioner, LosesInBurstsOfTheRequestedLength) {
  LinkConditioner link({.burst_enter = 0.01, .burst_leave = 0.05, .seed = 7});
  int lost = 0;
  int bursts = 0;
  bool before = false;
  for (std::int64_t t = 0; t < 200'000; ++t) {
    const bool now = !DueOf(link, t * kMs);
    lost += now ? 1 : 0;
    bursts += now && !before ? 1 : 0;
    before = now;
  }
  // a Markov chain: 1 / leave samples a burst, enter / (enter + leave) of all
  EXPECT_NEAR(static_cast<double>(lost) / bursts, 20.0, 2.0);
  EXPECT_NEAR(lost / 200'000.0, 1.0 / 6.0, 0.02);
}

TEST(LinkConditioner, DelayOscillates) {
  LinkConditioner link({.delay_ms = 100, .swing_ms = 40, .swing_period_s = 4, .seed = 1});
  std::vector<std::int64_t> delay;
  for (std::int64_t t = 0; t < 4000; ++t) delay.push_back(*DueOf(link, t * kMs) - t * kMs);
  EXPECT_EQ(delay[0], 100 * kMs);
  EXPECT_NEAR(static_cast<double>(delay[1000]), 140e6, 1e3);
  EXPECT_NEAR(static_cast<double>(delay[3000]), 60e6, 1e3);
}

TEST(LinkConditioner, ReordersTheRequestedShareOnly) {
  LinkConditioner link({.delay_ms = 20, .reorder = 0.1, .reorder_ms = 30, .seed = 11});
  int late = 0;
  for (std::int64_t t = 0; t < 20000; ++t) {
    const std::int64_t due = *DueOf(link, t * kMs);
    EXPECT_GE(due, (t + 20) * kMs);
    EXPECT_LE(due, (t + 50) * kMs);
    late += due > (t + 21) * kMs ? 1 : 0;  // the next one overtook it
  }
  EXPECT_NEAR(late, 2000.0 * 29 / 30, 5 * std::sqrt(1800.0));
}

TEST(LinkConditioner, DuplicatesTheRequestedShare) {
  LinkConditioner link({.delay_ms = 5, .duplicate = 0.2, .seed = 13});
  int twice = 0;
  for (std::int64_t t = 0; t < 20000; ++t) {
    std::array<std::int64_t, 2> due_ns{};
    const std::size_t copies = link.Due(t * kMs, due_ns);
    ASSERT_GE(copies, 1U);
    EXPECT_EQ(due_ns[0], (t + 5) * kMs);
    if (copies < 2) continue;
    ++twice;
    EXPECT_GT(due_ns[1], due_ns[0]);
  }
  EXPECT_NEAR(twice, 4000, 5 * std::sqrt(3200.0));
}

TEST(LinkConditioner, SwitchesWhileRunning) {
  LinkConditioner link({.delay_ms = 10});
  EXPECT_EQ(DueOf(link, 0), 10 * kMs);
  link.Switch({.cut = true});
  EXPECT_EQ(DueOf(link, 1 * kMs), std::nullopt);
  link.Switch({.delay_ms = 50});
  EXPECT_EQ(DueOf(link, 2 * kMs), 52 * kMs);
  link.Switch({.delay_ms = 0});
  // a better route does not let later samples overtake those on their way
  EXPECT_EQ(DueOf(link, 3 * kMs), 52 * kMs);
  EXPECT_EQ(DueOf(link, 60 * kMs), 60 * kMs);
}

TEST(LinkConditioner, IsDeterministicPerSeedAndStream) {
  const LinkConditions conditions{.delay_ms = 10, .jitter_ms = 30, .loss = 0.1, .seed = 9};
  LinkConditioner first(conditions);
  LinkConditioner second(conditions);
  LinkConditions other_seed = conditions;
  other_seed.seed = 10;
  LinkConditioner other(other_seed);
  LinkConditioner other_stream(conditions, 1);
  int differ = 0;
  int stream_differs = 0;
  for (std::int64_t t = 0; t < 1000; ++t) {
    const auto due = DueOf(first, t * kMs);
    EXPECT_EQ(due, DueOf(second, t * kMs));
    differ += due != DueOf(other, t * kMs) ? 1 : 0;
    stream_differs += due != DueOf(other_stream, t * kMs) ? 1 : 0;
  }
  EXPECT_GT(differ, 100);
  EXPECT_GT(stream_differs, 100);
}

TEST(LinkConditioner, NewSeedRestartsItsStream) {
  const LinkConditions conditions{.delay_ms = 10, .jitter_ms = 30, .loss = 0.1, .seed = 9};
  LinkConditioner fresh(conditions, 5);
  LinkConditioner switched({}, 5);
  switched.Switch(conditions);
  LinkConditioner other({}, 5);
  LinkConditions other_seed = conditions;
  other_seed.seed = 10;
  other.Switch(other_seed);
  int differ = 0;
  for (std::int64_t t = 0; t < 1000; ++t) {
    // within a seed the stream goes on
    if (t == 500) switched.Switch(conditions);
    const auto due = DueOf(fresh, t * kMs);
    EXPECT_EQ(due, DueOf(switched, t * kMs));
    differ += due != DueOf(other, t * kMs) ? 1 : 0;
  }
  EXPECT_GT(differ, 100);
}

}  // namespace
}  // namespace tandem
