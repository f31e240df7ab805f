#include "engine/realtime/spsc_queue.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

struct Sample {
  std::uint64_t number = 0;
  std::array<std::uint64_t, 7> copies{};  // copies of the number: all equal unless torn
};

Sample MakeSample(std::uint64_t number) {
  Sample sample{number, {}};
  for (std::uint64_t& copy : sample.copies) copy = number;
  return sample;
}

TEST(SpscQueue, HoldsItsCapacityAndNoMore) {
  for (const std::size_t capacity : {std::size_t{1}, std::size_t{5}, std::size_t{8}}) {
    SpscQueue<int> queue(capacity);
    int value = -1;
    EXPECT_FALSE(queue.TryPop(value));
    EXPECT_EQ(value, -1);
    for (int round = 0; round < 3; ++round) {
      for (std::size_t i = 0; i < capacity; ++i) EXPECT_TRUE(queue.TryPush(static_cast<int>(i)));
      EXPECT_FALSE(queue.TryPush(99));
      for (std::size_t i = 0; i < capacity; ++i) {
        ASSERT_TRUE(queue.TryPop(value));
        EXPECT_EQ(value, static_cast<int>(i));
      }
      EXPECT_FALSE(queue.TryPop(value));
    }
  }
}

TEST(SpscQueue, PeeksAtTheOldest) {
  SpscQueue<int> queue(2);
  EXPECT_EQ(queue.Front(), nullptr);
  queue.TryPush(1);
  queue.TryPush(2);
  ASSERT_NE(queue.Front(), nullptr);
  EXPECT_EQ(*queue.Front(), 1);
  EXPECT_EQ(*queue.Front(), 1);
  queue.Drop();
  EXPECT_EQ(*queue.Front(), 2);
  queue.Drop();
  EXPECT_EQ(queue.Front(), nullptr);
}

TEST(SpscQueue, CarriesEverythingInOrderBetweenTwoThreads) {
  constexpr std::uint64_t kCount = 300'000;
  SpscQueue<Sample> queue(37);
  std::thread pusher([&queue] {
    for (std::uint64_t i = 0; i < kCount; ++i) {
      const Sample sample = MakeSample(i);
      while (!queue.TryPush(sample)) std::this_thread::yield();
    }
  });
  std::uint64_t wrong = 0;
  Sample sample;
  for (std::uint64_t expected = 0; expected < kCount; ++expected) {
    while (!queue.TryPop(sample)) std::this_thread::yield();
    wrong += static_cast<std::uint64_t>(sample.number != expected);
    for (const std::uint64_t copy : sample.copies) {
      wrong += static_cast<std::uint64_t>(copy != expected);
    }
  }
  pusher.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_FALSE(queue.TryPop(sample));
}

TEST(SpscQueue, AllocatesNothingAfterConstruction) {
  SpscQueue<Sample> queue(100);
  Sample sample;
  int popped = 0;
  const testing::AllocationCounter allocations;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    queue.TryPush(MakeSample(i));
    popped += static_cast<int>(i % 2 == 0 && queue.TryPop(sample));
  }
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_EQ(popped, 500);
}

}  // namespace
}  // namespace tandem
