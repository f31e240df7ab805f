#include "app/device/drivers/handle_sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem::driver {
namespace {

TEST(HandleSampleTest, GivesTheLoopAllThatWasMeasured) {
  HandleSample sample;
  sample.time_ns = 7;
  sample.valid = TANDEM_HAS_POSE;
  sample.buttons = TANDEM_BUTTON_STOP;
  sample.p_VD = {1, 2, 3};
  sample.q_VD = {0.1, 0.2, 0.3, 0.4};
  sample.v_VD = {4, 5, 6};
  sample.w_VD = {7, 8, 9};
  TandemDeviceState state{};
  sample.CopyTo(state);
  EXPECT_EQ(state.time_ns, 7);
  EXPECT_EQ(state.valid, static_cast<std::uint32_t>(TANDEM_HAS_POSE));
  EXPECT_EQ(state.buttons, static_cast<std::uint32_t>(TANDEM_BUTTON_STOP));
  EXPECT_THAT(state.position, ::testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(state.orientation, ::testing::ElementsAre(0.1, 0.2, 0.3, 0.4));
  EXPECT_THAT(state.velocity, ::testing::ElementsAre(4, 5, 6));
  EXPECT_THAT(state.angular_velocity, ::testing::ElementsAre(7, 8, 9));
}

TEST(HandleSampleTest, FailsUntilSomethingIsMeasured) {
  EXPECT_EQ(HandleSample{}.result, TANDEM_FAILED);
}

}  // namespace
}  // namespace tandem::driver
