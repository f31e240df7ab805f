#include "collab/recording/byte_ring.h"

#include <thread>

#include <gtest/gtest.h>

namespace tandem {
namespace {

void PutBlock(ByteRing& ring, std::uint32_t value, std::size_t words) {
  ring.Open();
  for (std::size_t i = 0; i < words; ++i) ring.Put(&value, sizeof value);
}

TEST(ByteRing, BlockThatDoesNotFitIsDroppedWhole) {
  ByteRing ring(64);
  PutBlock(ring, 7, 10);
  EXPECT_TRUE(ring.Commit());
  PutBlock(ring, 8, 6);
  EXPECT_FALSE(ring.Commit());
  PutBlock(ring, 9, 2);
  EXPECT_TRUE(ring.Commit());
  std::vector<std::byte> out;
  ring.TakeAll(out);
  EXPECT_EQ(out.size(), 4 + 40 + 4 + 8U);
  PutBlock(ring, 10, 15);
  EXPECT_TRUE(ring.Commit()) << "room is given back";
}

TEST(ByteRing, BlocksComeOutWholeAndInOrder) {
  constexpr std::uint32_t kBlocks = 100000;
  ByteRing ring(1024);
  std::thread putting([&] {
    for (std::uint32_t value = 0; value < kBlocks;) {
      PutBlock(ring, value, 1 + value % 13);
      if (ring.Commit()) ++value;
    }
  });
  std::uint32_t expected = 0;
  std::vector<std::byte> out;
  while (expected < kBlocks) {
    out.clear();
    ring.TakeAll(out);
    std::size_t at = 0;
    const auto next = [&] {
      std::uint32_t word = 0;
      std::memcpy(&word, &out[at], sizeof word);
      at += sizeof word;
      return word;
    };
    while (at < out.size()) {
      ASSERT_EQ(next(), 4 * (1 + expected % 13));
      for (std::uint32_t i = 0; i < 1 + expected % 13; ++i) ASSERT_EQ(next(), expected);
      ++expected;
    }
  }
  putting.join();
}

}  // namespace
}  // namespace tandem
