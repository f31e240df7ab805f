#include "engine/base/text/hex.h"

#include <array>

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(HexTest, ANumberHasAllSixteenDigits) {
  EXPECT_EQ(Hex(0xabc), "0000000000000abc");
  EXPECT_EQ(Hex(~std::uint64_t{0}), "ffffffffffffffff");
}

TEST(HexTest, BytesHaveTwoDigitsEachInTheirOrder) {
  EXPECT_EQ(HexOfBytes(std::array<std::uint8_t, 3>{0x00, 0x0f, 0xa5}), "000fa5");
}

}  // namespace
}  // namespace tandem
