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

TEST(BorneBy, AGainThatIsNoneLeavesNoSpringAndAnInfiniteOneIsAny) {
  for (const double claimed : {std::numeric_limits<double>::quiet_NaN(), -1.0, 0.0,
                               -std::numeric_limits<double>::infinity()}) {
    DeviceCapabilities can;
    can.stiffness = can.damping = can.rotation_stiffness = can.rotation_damping = claimed;
    const CouplingGains borne = BorneBy(can, Some());
    EXPECT_EQ(borne.stiffness, 0) << claimed;
    EXPECT_EQ(borne.damping, 0) << claimed;
    EXPECT_TRUE(borne.rotation_stiffness.isZero()) << claimed;
    EXPECT_TRUE(borne.rotation_damping.isZero()) << claimed;
    const std::string said = WhatGainsBecame("it", can);
    EXPECT_THAT(said, ::testing::HasSubstr("it: a stiffness of "));
    EXPECT_THAT(said, ::testing::HasSubstr("a rotation damping of "));
  }
  const CouplingGains borne = BorneBy(DeviceCapabilities{}, Some());
  EXPECT_EQ(borne.stiffness, 1000);
  EXPECT_EQ(borne.rotation_damping, Some().rotation_damping);
  EXPECT_EQ(WhatGainsBecame("it", DeviceCapabilities{}), "");
}

}  // namespace
}  // namespace tandem
