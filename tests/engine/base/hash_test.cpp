#include "engine/base/hash.h"

#include <bit>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

namespace tandem {
namespace {

std::uint64_t HashOf(const std::string& text) {
  Hash64 hash;
  hash.AddBytes(text.data(), text.size());
  return hash.value();
}

TEST(Hash64, IsDeterministicAndIndependentOfChunking) {
  Hash64 in_pieces;
  in_pieces.AddBytes("tan", 3);
  in_pieces.AddBytes("dem", 3);
  EXPECT_EQ(in_pieces.value(), HashOf("tandem"));
}

TEST(Hash64, IsMixedFnv1a) {
  // FNV-1a of "a" is af63dc4c8601ec8c (the published test vector), then MurmurHash3's 64-bit
  // finalizer.
  std::uint64_t x = 0xaf63dc4c8601ec8cULL;
  x = (x ^ (x >> 33U)) * 0xff51afd7ed558ccdULL;
  x = (x ^ (x >> 33U)) * 0xc4ceb9fe1a85ec53ULL;
  EXPECT_EQ(HashOf("a"), x ^ (x >> 33U));
}

TEST(Hash64, DependsOnOrder) {
  EXPECT_NE(HashOf("ab"), HashOf("ba"));
}

TEST(Hash64, OneInputBitChangesHalfTheOutputBits) {
  Hash64 zero;
  zero.Add(std::uint64_t{0});
  for (unsigned bit = 0; bit < 64; ++bit) {
    Hash64 hash;
    hash.Add(std::uint64_t{1} << bit);
    EXPECT_GT(std::popcount(hash.value() ^ zero.value()), 12) << "bit " << bit;
  }
}

TEST(Hash64, DistinguishesZeroFromNegativeZero) {
  Hash64 plus;
  plus.Add(0.0);
  Hash64 minus;
  minus.Add(-0.0);
  EXPECT_NE(plus.value(), minus.value());
}

}  // namespace
}  // namespace tandem
