#include "engine/safety/device_limits.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kEndless = std::numeric_limits<double>::infinity();

TEST(DeviceLimits, SafetyLimitBoundsDriverAndUser) {
  for (const double claimed : {30.1, 1e6, std::numeric_limits<double>::max()}) {
    EXPECT_EQ(ValidLimits({claimed, claimed}).force, 30.0);
    EXPECT_EQ(ValidLimits({claimed, claimed}).moment, 1.0);
    EXPECT_EQ(ValidLimits({claimed, claimed}, {claimed, claimed}).force, 30.0);
    EXPECT_EQ(ValidLimits({claimed, claimed}, {claimed, claimed}).moment, 1.0);
  }
}

TEST(DeviceLimits, InvalidLimitIsZero) {
  for (const double claimed : {0.0, -1.0, kNotANumber, kEndless, -kEndless}) {
    EXPECT_EQ(ValidLimits({claimed, 0.2}).force, 0.0);
    EXPECT_EQ(ValidLimits({claimed, 0.2}).moment, 0.2);
    EXPECT_EQ(ValidLimits({5, claimed}).moment, 0.0);
    EXPECT_EQ(ValidLimits({5, 0.2}, {claimed, 0.1}).force, 0.0);
  }
}

TEST(DeviceLimits, UserAndDeviceLimitsBothApply) {
  EXPECT_EQ(ValidLimits({3.3, 0.5}, {8, 0.1}).force, 3.3);
  EXPECT_EQ(ValidLimits({3.3, 0.5}, {8, 0.1}).moment, 0.1);
}

TEST(DeviceLimits, ReportsClampedLimits) {
  EXPECT_EQ(DescribeLimitChange("the driver", {12, 0.5}), "");
  EXPECT_EQ(DescribeLimitChange("the driver", {1000, 0.5}),
            "the driver: a force of 1000 N is held to 30 N");
  EXPECT_THAT(DescribeLimitChange("x", {kNotANumber, -1}),
              ::testing::HasSubstr("counts as zero; a moment"));
}

}  // namespace
}  // namespace tandem
