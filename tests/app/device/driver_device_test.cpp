// Tests what tandem-device makes of a driver whose every answer the test gives.
#include "app/device/driver_device.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

using testing::AllocationCounter;
using ::testing::HasSubstr;

/// The answers of the driver under the test's hand, and the calls that it got.
struct ScriptedDriver {
  std::int32_t open = TANDEM_OK;
  std::int32_t start = TANDEM_OK;
  std::int32_t read = TANDEM_OK;
  std::int32_t write = TANDEM_OK;
  TandemDeviceCapabilities can{};
  TandemDeviceState state{};
  TandemDeviceForce force{};
  std::string error;
  std::string options;
  const TandemDeviceHost* host = nullptr;
  int closes = 0;
  int deinits = 0;
  int stops = 0;
};
ScriptedDriver scripted;

TandemDriver PuppetDriver() {
  TandemDriver driver{};
  driver.struct_size = sizeof driver;
  driver.abi_major = TANDEM_DEVICE_ABI_MAJOR;
  driver.name = "puppet";
  driver.kind = "puppet of a test";
  driver.options = "";
  driver.init = [](const TandemDeviceHost* host) {
    scripted.host = host;
    return std::int32_t{TANDEM_OK};
  };
  driver.deinit = [] {
    ++scripted.deinits;
  };
  driver.list = [](TandemDeviceFound*, std::int32_t) {
    return 0;
  };
  driver.open = [](const TandemDeviceOpen* how, TandemDevice** device) {
    scripted.options = how->options;
    if (scripted.open == TANDEM_OK) *device = reinterpret_cast<TandemDevice*>(&scripted);
    return scripted.open;
  };
  driver.close = [](TandemDevice*) {
    ++scripted.closes;
  };
  driver.capabilities = [](TandemDevice*, TandemDeviceCapabilities* can) {
    *can = scripted.can;
    return std::int32_t{TANDEM_OK};
  };
  driver.start = [](TandemDevice*) {
    return scripted.start;
  };
  driver.read = [](TandemDevice*, TandemDeviceState* state) {
    if (scripted.read == TANDEM_OK) *state = scripted.state;
    return scripted.read;
  };
  driver.write = [](TandemDevice*, const TandemDeviceForce* force) {
    scripted.force = *force;
    return scripted.write;
  };
  driver.stop = [](TandemDevice*) {
    ++scripted.stops;
  };
  driver.last_error = [](TandemDevice*, char* text, std::uint32_t room) {
    if (scripted.error.empty()) return std::int32_t{TANDEM_FAILED};
    std::snprintf(text, room, "%s", scripted.error.c_str());
    return std::int32_t{TANDEM_OK};
  };
  return driver;
}

class DriverDeviceTest : public ::testing::Test {
 protected:
  DriverDeviceTest() : driver_(PuppetDriver()) {
    scripted = {};
    scripted.can.freedoms_in = 6;
    scripted.can.freedoms_out = 3;
    scripted.can.peak_force = 8;
    MoveTo(Vec3(0.1, 0.2, 0.3));
  }
  static void MoveTo(const Vec3& p, const Quat& q = Quat::Identity()) {
    scripted.state.valid = TANDEM_HAS_POSE;
    for (int i = 0; i < 3; ++i) scripted.state.position[i] = p[i];
    for (int i = 0; i < 4; ++i) scripted.state.orientation[i] = q.coeffs()[i];
  }
  /// Gives a pose a millisecond after the last one.
  void Go(const Vec3& p, const Quat& q = Quat::Identity()) {
    MoveTo(p, q);
    scripted.state.time_ns = time_ns_ += 1'000'000;
  }
  Result<std::unique_ptr<DriverDevice>> Open(const std::string& options = "") {
    return DriverDevice::Open(driver_, options, home_);
  }

  TandemDriver driver_;
  const Pose home_{RotationBy(Vec3(0, 0, 1)), Vec3(1, 2, 3)};
  std::int64_t time_ns_ = 0;
};

TEST_F(DriverDeviceTest, HandleStartsAtThePartAndMovesInTheDevicesFrame) {
  const auto device = Open("a=b");
  ASSERT_TRUE(device);
  EXPECT_EQ(scripted.options, "a=b");
  EXPECT_LT(((*device)->Read().X_WA.p - home_.p).norm(), 1e-12);
  const Quat turn = RotationBy(Vec3(0.2, 0, 0));
  MoveTo(Vec3(0.1, 0.25, 0.3), turn);
  const Anchor handle = (*device)->Read();
  EXPECT_LT((handle.X_WA.p - (home_.p + Vec3(0, 0.05, 0))).norm(), 1e-12);
  EXPECT_LT(handle.X_WA.q.angularDistance(turn * home_.q), 1e-12);
  EXPECT_FALSE((*device)->capabilities().in_scene);
}

TEST_F(DriverDeviceTest, WorkspaceMovesWithTheHandlesFirstPosition) {
  for (int i = 0; i < 3; ++i) {
    scripted.can.workspace_min[i] = -0.5;
    scripted.can.workspace_max[i] = 0.5;
  }
  const auto device = Open();
  ASSERT_TRUE(device);
  const Vec3 middle = (*device)->capabilities().workspace.centre();
  EXPECT_LT((middle - (home_.p - Vec3(0.1, 0.2, 0.3))).norm(), 1e-12);
}

TEST_F(DriverDeviceTest, PoseInTheSceneFrameIsUsedUnchanged) {
  scripted.can.in_scene = 1;
  const auto device = Open();
  ASSERT_TRUE(device);
  EXPECT_EQ((*device)->Read().X_WA.p, Vec3(0.1, 0.2, 0.3));
  EXPECT_TRUE((*device)->capabilities().in_scene);
}

TEST_F(DriverDeviceTest, MissingSpeedIsDerivedFromPoses) {
  const auto device = Open();
  ASSERT_TRUE(device);
  Anchor handle;
  // 0.2 m/s along x, and 1 rad/s about z; a mean over 5 ms is there after 50
  for (int i = 0; i < 50; ++i) {
    Go(Vec3(0.1 + 0.0002 * i, 0.2, 0.3), RotationBy(Vec3(0, 0, 0.001 * i)));
    handle = (*device)->Read();
  }
  EXPECT_NEAR(handle.V_WA.v.x(), 0.2, 2e-4);
  EXPECT_NEAR(handle.V_WA.w.z(), 1.0, 1e-3);
  // a driver that says that it has a velocity knows better
  scripted.state.valid |= TANDEM_HAS_VELOCITY;
  scripted.state.velocity[0] = 0.7;
  EXPECT_EQ((*device)->Read().V_WA.v.x(), 0.7);
}

TEST_F(DriverDeviceTest, ReconnectedDeviceContinuesWithoutAJump) {
  const auto device = Open();
  ASSERT_TRUE(device);
  Go(Vec3(0.12, 0.2, 0.3));
  const Vec3 before = (*device)->Read().X_WA.p;
  scripted.read = TANDEM_UNPLUGGED;
  scripted.error = "the cable is out: plug it in";
  Anchor handle = (*device)->Read();
  EXPECT_TRUE((*device)->failed());
  EXPECT_EQ((*device)->Trouble(), "puppet: the cable is out: plug it in");
  EXPECT_EQ(handle.X_WA.p, before);
  EXPECT_TRUE(handle.V_WA.v.isZero());
  // plugged in again half a metre away
  scripted.read = TANDEM_OK;
  Go(Vec3(0.62, 0.2, 0.3));
  handle = (*device)->Read();
  EXPECT_FALSE((*device)->failed());
  EXPECT_EQ((*device)->Trouble(), "");
  EXPECT_LT((handle.X_WA.p - before).norm(), 1e-12);
  Go(Vec3(0.63, 0.2, 0.3));
  EXPECT_NEAR((*device)->Read().X_WA.p.x(), before.x() + 0.01, 1e-12);
}

TEST_F(DriverDeviceTest, OneFailedReadMovesNothing) {
  const auto device = Open();
  ASSERT_TRUE(device);
  scripted.read = TANDEM_FAILED;
  (*device)->Read();
  EXPECT_TRUE((*device)->failed());
  scripted.read = TANDEM_OK;
  Go(Vec3(0.11, 0.2, 0.3));
  EXPECT_NEAR((*device)->Read().X_WA.p.x(), home_.p.x() + 0.01, 1e-12);
}

TEST_F(DriverDeviceTest, InvalidPoseIsAFailureAndHoldsTheHand) {
  const auto device = Open();
  ASSERT_TRUE(device);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Quat& q : {Quat(0, 0, 0, 0), Quat(nan, 0, 0, 0), Quat(2, 0, 0, 0)}) {
    Go(Vec3(0.2, 0.2, 0.3), q);
    EXPECT_EQ((*device)->Read().X_WA.p, home_.p);
    EXPECT_TRUE((*device)->failed());
  }
  Go(Vec3(nan, 0.2, 0.3));
  EXPECT_EQ((*device)->Read().X_WA.p, home_.p);
  EXPECT_TRUE((*device)->failed());
}

TEST_F(DriverDeviceTest, MotorsGetTheForceAndTheStart) {
  const auto device = Open();
  ASSERT_TRUE(device);
  (*device)->Render({Vec3(0.1, 0, 0), Vec3(0, 2, 0)});
  EXPECT_EQ(scripted.force.force[1], 2);
  EXPECT_EQ(scripted.force.moment[0], 0.1);
  EXPECT_EQ(scripted.force.begun, 0U);
  (*device)->Start();
  (*device)->Render({});
  EXPECT_EQ(scripted.force.begun, 1U);
  scripted.write = TANDEM_FAILED;
  (*device)->Render({});
  EXPECT_TRUE((*device)->failed());
  (*device)->Stop();
  EXPECT_EQ(scripted.stops, 1);
}

TEST_F(DriverDeviceTest, VendorThreadReadsTheForceUntilItIsCut) {
  scripted.can.asks = 1;
  const auto device = Open();
  ASSERT_TRUE(device);
  EXPECT_TRUE((*device)->capabilities().asks_us);
  TandemDeviceForce taken{};
  // a ramp takes a second: by its end the whole force is there
  for (int i = 0; i < 1300; ++i) {
    (*device)->Render({Vec3::Zero(), Vec3(2, 0, 0)});
    scripted.host->take(scripted.host->context, &taken);
    if (taken.force[0] > 1) break;
    const std::int64_t until_ns = scripted.host->now_ns() + 1'000'000;
    while (scripted.host->now_ns() < until_ns) {
    }
  }
  EXPECT_GT(taken.force[0], 1);
  (*device)->Stop();
  scripted.host->take(scripted.host->context, &taken);
  EXPECT_EQ(taken.force[0], 0);
}

TEST_F(DriverDeviceTest, ButtonsReachTheLoop) {
  const auto device = Open();
  ASSERT_TRUE(device);
  scripted.state.buttons = TANDEM_BUTTON_CLUTCH;
  (*device)->Read();
  EXPECT_TRUE((*device)->clutch_button());
  EXPECT_FALSE((*device)->stop_button());
  scripted.state.buttons = TANDEM_BUTTON_STOP;
  (*device)->Read();
  EXPECT_TRUE((*device)->stop_button());
}

TEST_F(DriverDeviceTest, DriverRefusalIsReportedAndNothingStaysOpen) {
  scripted.open = TANDEM_FAILED;
  scripted.error = "no such device: plug it in";
  auto device = Open();
  ASSERT_FALSE(device);
  EXPECT_EQ(device.error().what, "puppet: no such device: plug it in");
  EXPECT_EQ(scripted.closes, 0);
  EXPECT_EQ(scripted.deinits, 1);

  scripted.open = TANDEM_OK;
  scripted.start = TANDEM_UNCALIBRATED;
  scripted.error = "";
  device = Open();
  ASSERT_FALSE(device);
  EXPECT_THAT(device.error().what, HasSubstr("does not start"));
  EXPECT_EQ(scripted.closes, 1);
  EXPECT_EQ(scripted.deinits, 2);
}

TEST_F(DriverDeviceTest, ATickAllocatesNothing) {
  const auto device = Open();
  ASSERT_TRUE(device);
  const AllocationCounter counter;
  for (int i = 0; i < 100; ++i) {
    scripted.read = i % 3 == 0 ? TANDEM_UNPLUGGED : TANDEM_OK;
    (*device)->Read();
    (*device)->Render({Vec3::Zero(), Vec3(1, 0, 0)});
  }
  EXPECT_EQ(counter.count(), 0);
}

}  // namespace
}  // namespace tandem
