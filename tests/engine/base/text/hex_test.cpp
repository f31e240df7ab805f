#include "engine/base/text/hex.h"

#include <array>

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(HexTest, ANumberHasAllSixteenDigits) {
  EXPECT_EQ(Hex(0xabc), "0000000000000abc");
  EXPECT_EQ(Hex(~std::uint64_t{0}), "ffffffffffffffff");
}

TEST(HexTest, SixteenDigitsAreReadAndNoOtherText) {
  EXPECT_EQ(FromHex("0000000000000abc"), std::optional<std::uint64_t>(0xabc));
  EXPECT_EQ(FromHex("ffffffffffffffff"), std::optional<std::uint64_t>(~std::uint64_t{0}));
  for (const char* text : {"", "abc", "000000000000000", "00000000000000000", "000000000000000g",
                           " 00000000000000a", "-000000000000001", "0x00000000000001"}) {
    EXPECT_FALSE(FromHex(text)) << text;
  }
}

TEST(HexTest, BytesHaveTwoDigitsEachInTheirOrder) {
  EXPECT_EQ(HexOfBytes(std::array<std::uint8_t, 3>{0x00, 0x0f, 0xa5}), "000fa5");
}

}  // namespace
}  // namespace tandem
