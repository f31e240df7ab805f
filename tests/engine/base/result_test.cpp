#include "engine/base/result.h"

#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace tandem {
namespace {

Result<int> Half(int number) {
  if (number % 2 != 0) return Error{std::to_string(number) + " is odd"};
  return number / 2;
}

TEST(Result, HasAValueOrAnError) {
  const Result<int> good = Half(8);
  ASSERT_TRUE(good);
  EXPECT_TRUE(good.has_value());
  EXPECT_EQ(*good, 4);

  const Result<int> bad = Half(7);
  EXPECT_FALSE(bad);
  EXPECT_EQ(bad.error().what, "7 is odd");
}

TEST(Result, SupportsMoveOnlyValues) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  const std::unique_ptr<int> taken = *std::move(result);
  ASSERT_NE(taken, nullptr);
  EXPECT_EQ(*taken, 5);
}

TEST(Result, MayHoldAString) {
  Result<std::string> result(std::string("a value"));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->size(), 7U);
  result->append("!");
  EXPECT_EQ(result.value(), "a value!");
}

TEST(ResultDeathTest, AccessToAMissingValueAborts) {
  EXPECT_DEATH(static_cast<void>(Half(7).value()), "check failed");
  EXPECT_DEATH(static_cast<void>(Half(8).error()), "check failed");
}

}  // namespace
}  // namespace tandem
