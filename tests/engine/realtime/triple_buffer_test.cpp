#include "engine/realtime/triple_buffer.h"

#include <array>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

namespace tandem {
namespace {

struct Snapshot {
  std::array<std::uint64_t, 8> copies{};  // all equal unless torn
};

TEST(TripleBuffer, KeepsTheNewestValue) {
  TripleBuffer<int> buffer;
  EXPECT_EQ(buffer.Read(), 0);
  for (const int value : {1, 2, 3}) {
    buffer.back() = value;
    buffer.Publish();
  }
  EXPECT_EQ(buffer.Read(), 3);
  EXPECT_EQ(buffer.Read(), 3);
  buffer.back() = 4;
  EXPECT_EQ(buffer.Read(), 3);
  buffer.Publish();
  EXPECT_EQ(buffer.Read(), 4);
}

TEST(TripleBuffer, IsNeverTornAndMonotonicBetweenTwoThreads) {
  constexpr std::uint64_t kCount = 300'000;
  TripleBuffer<Snapshot> buffer;
  std::thread writer([&buffer] {
    for (std::uint64_t i = 1; i <= kCount; ++i) {
      for (std::uint64_t& copy : buffer.back().copies) copy = i;
      buffer.Publish();
    }
  });
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  std::uint64_t newest = 0;
  while (newest < kCount) {
    const Snapshot& snapshot = buffer.Read();
    const std::uint64_t number = snapshot.copies[0];
    for (const std::uint64_t copy : snapshot.copies) {
      torn += static_cast<std::uint64_t>(copy != number);
    }
    backwards += static_cast<std::uint64_t>(number < newest);
    newest = number;
  }
  writer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(backwards, 0U);
}

}  // namespace
}  // namespace tandem
