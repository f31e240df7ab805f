#include "app/device/drivers/rate_hand_driver.h"

#include <gtest/gtest.h>

namespace tandem::driver {
namespace {

constexpr TandemDeviceHost kNoHost{};

class StillDriver : public RateHandDriver {
 public:
  StillDriver() : RateHandDriver(kNoHost) {}
  double AlongXAt(std::int64_t now_ns) {
    hand_.Move(Vec3::Zero(), Vec3::Zero(), now_ns);
    TandemDeviceState state{};
    hand_.Tell(state);
    return state.position[0];
  }
};

TEST(RateHandDriverTest, HasSixFreedomsInAndNoMotors) {
  TandemDeviceCapabilities can{};
  EXPECT_EQ(StillDriver::Capabilities(can), "");
  EXPECT_EQ(can.freedoms_in, 6U);
  EXPECT_EQ(can.freedoms_out, 0U);
  EXPECT_GT(can.stiffness, 0);
}

TEST(RateHandDriverTest, ItsHandYieldsToTheForceThatIsWritten) {
  StillDriver driver;
  TandemDeviceForce force{};
  force.force[0] = 5;
  EXPECT_EQ(driver.Write(force), TANDEM_OK);
  for (int i = 0; i < 100; ++i) driver.AlongXAt(i * 1'000'000);
  EXPECT_GT(driver.AlongXAt(100'000'000), 0);
}

}  // namespace
}  // namespace tandem::driver
