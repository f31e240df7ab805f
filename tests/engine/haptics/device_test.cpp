#include "engine/haptics/device.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

CouplingGains Some() {
  CouplingGains gains;
  gains.stiffness = 1000;
  gains.damping = 3;
  gains.rotation_stiffness = 2 * Mat3::Identity();
  gains.rotation_damping = 0.1 * Mat3::Identity();
  return gains;
}

TEST(LimitGains, InvalidGainMeansNoSpringAndInfiniteGainNoLimit) {
  for (const double claimed : {std::numeric_limits<double>::quiet_NaN(), -1.0, 0.0,
                               -std::numeric_limits<double>::infinity()}) {
    DeviceCapabilities can;
    can.stiffness = can.damping = can.rotation_stiffness = can.rotation_damping = claimed;
    const CouplingGains borne = LimitGains(can, Some());
    EXPECT_EQ(borne.stiffness, 0) << claimed;
    EXPECT_EQ(borne.damping, 0) << claimed;
    EXPECT_TRUE(borne.rotation_stiffness.isZero()) << claimed;
    EXPECT_TRUE(borne.rotation_damping.isZero()) << claimed;
    const std::string stated = DescribeGainChange("it", can);
    EXPECT_THAT(stated, ::testing::HasSubstr("it: a stiffness of "));
    EXPECT_THAT(stated, ::testing::HasSubstr("a rotation damping of "));
  }
  const CouplingGains borne = LimitGains(DeviceCapabilities{}, Some());
  EXPECT_EQ(borne.stiffness, 1000);
  EXPECT_EQ(borne.rotation_damping, Some().rotation_damping);
  EXPECT_EQ(DescribeGainChange("it", DeviceCapabilities{}), "");
}

TEST(Device, CouplingGainsStayWithinTheDevicesLimits) {
  const CouplingGains gains{800, 8, Vec3(0.4, 0.2, 0.1).asDiagonal(), 0.004 * Mat3::Identity()};
  const CouplingGains all = LimitGains({}, gains);
  EXPECT_EQ(all.stiffness, 800);
  EXPECT_EQ(all.rotation_stiffness, gains.rotation_stiffness);
  DeviceCapabilities weak;
  weak.stiffness = 500;
  weak.damping = 5;
  weak.rotation_stiffness = 0.1;
  const CouplingGains borne = LimitGains(weak, gains);
  EXPECT_EQ(borne.stiffness, 500);
  EXPECT_EQ(borne.damping, 5);
  EXPECT_NEAR((borne.rotation_stiffness.diagonal() - Vec3(0.1, 0.05, 0.025)).norm(), 0, 1e-15);
  EXPECT_EQ(borne.rotation_damping, gains.rotation_damping);
}

}  // namespace
}  // namespace tandem
