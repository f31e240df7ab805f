#include "collab/dds/cyclone/writer_rate_limiter.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

constexpr WriterLimits kLimits{.per_second = 1000, .at_once = 100, .keys = 10, .of_one = 3};

TEST(WriterRateLimiter, WriterWithinItsRateIsNeverRefused) {
  WriterRateLimiter gate(kLimits);
  for (std::int64_t i = 0; i < 10'000; ++i) {
    ASSERT_FALSE(gate.Refuses(7, 1, static_cast<std::uint64_t>(1 + i % 10), i * kMs)) << i;
  }
}

TEST(WriterRateLimiter, DelayedSamplesMayArriveInABurst) {
  WriterRateLimiter gate(kLimits);
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(gate.Refuses(7, 1, 1, kMs)) << i;
}

TEST(WriterRateLimiter, FloodMutesItsWriterForAWhile) {
  WriterRateLimiter gate(kLimits);
  // ten times the rate, for ten seconds
  int let_through = 0;
  for (std::int64_t i = 0; i < 100'000; ++i) {
    const auto refused = gate.Refuses(7, 1, 1, i * kMs / 10);
    if (refused) {
      EXPECT_EQ(*refused, Drop::kFlood);
    } else {
      ++let_through;
    }
  }
  EXPECT_LE(let_through, 10'000 + 100);
  // it has stopped, and is heard again
  EXPECT_FALSE(gate.Refuses(7, 1, 1, 20'000 * kMs));
}

TEST(WriterRateLimiter, FloodOfOneWriterDoesNotAffectOthers) {
  WriterRateLimiter gate(kLimits);
  for (std::int64_t i = 0; i < 10'000; ++i) {
    for (int n = 0; n < 100; ++n) gate.Refuses(7, 1, 1, i * kMs);
    ASSERT_FALSE(gate.Refuses(8, 2, 1, i * kMs)) << i;
  }
}

TEST(WriterRateLimiter, ForgedKeysAreNotKept) {
  WriterRateLimiter gate({.per_second = 1'000'000, .at_once = 1'000'000, .keys = 10, .of_one = 3});
  int kept = 0;
  for (std::uint64_t key = 1; key <= 1'000'000; ++key) {
    const auto refused = gate.Refuses(7, 1, key, static_cast<std::int64_t>(key) * 1000);
    if (refused) {
      ASSERT_EQ(*refused, Drop::kManyKeys);
    } else {
      ++kept;
    }
  }
  EXPECT_EQ(kept, 10);
  EXPECT_EQ(gate.keys(), 10U);
  EXPECT_FALSE(gate.Refuses(7, 1, 5, 2'000'000'000));  // one of the writers that it has
}

TEST(WriterRateLimiter, TotalRateIsBounded) {
  WriterRateLimiter gate(
      {.per_second = 1'000'000, .at_once = 1'000'000, .keys = 1000, .of_one = 3});
  std::size_t kept = 0;
  for (std::uint64_t writer = 1; writer <= 100; ++writer) {
    for (std::uint64_t key = 1; key <= 1000; ++key) {
      if (!gate.Refuses(writer, writer, 1000 * writer + key, 0)) ++kept;
    }
  }
  EXPECT_EQ(kept, WriterRateLimiter::kMaxKeys);
}

TEST(WriterRateLimiter, WritersAreBoundedPerProgramAndInTotal) {
  WriterRateLimiter gate(kLimits);
  for (std::uint64_t writer = 1; writer <= 3; ++writer) EXPECT_FALSE(gate.Refuses(writer, 1, 1, 0));
  EXPECT_EQ(gate.Refuses(4, 1, 1, 0), Drop::kManyWriters);
  std::size_t received = 3;
  for (std::uint64_t writer = 10; writer < 1000; ++writer) {
    if (!gate.Refuses(writer, writer, 1, 0)) ++received;
  }
  EXPECT_EQ(received, WriterRateLimiter::kMaxWriters);
  // the writer that came first keeps the place
  EXPECT_FALSE(gate.Refuses(1, 1, 1, 0));
}

TEST(WriterRateLimiter, DepartedWriterFreesItsSlot) {
  WriterRateLimiter gate(kLimits);
  for (std::uint64_t writer = 1; writer <= 200; ++writer) {
    for (std::uint64_t key = 1; key <= 10; ++key) {
      ASSERT_FALSE(gate.Refuses(writer, writer, 100 * writer + key, 0));
    }
  }
  ASSERT_EQ(gate.keys(), 2000U);
  for (std::uint64_t writer = 1; writer <= 200; writer += 2) gate.Forget(writer);
  EXPECT_EQ(gate.keys(), 1000U);
  EXPECT_EQ(gate.writers(), 100U);
  gate.Forget(12345);  // nobody has that number
  for (std::uint64_t writer = 2; writer <= 200; writer += 2) {
    for (std::uint64_t key = 1; key <= 10; ++key) {
      ASSERT_FALSE(gate.Refuses(writer, writer, 100 * writer + key, 0));
    }
    ASSERT_EQ(gate.Refuses(writer, writer, 7, 0), Drop::kManyKeys);
  }
  EXPECT_EQ(gate.keys(), 1000U);
}

}  // namespace
}  // namespace tandem
