#include "engine/haptics/process_device.h"

#include <gtest/gtest.h>

#include "tests/engine/haptics/device_link.h"

namespace tandem {
namespace {

using testing::CountingDriver;
using testing::HandClock;
using testing::Link;

TEST(ProcessDevice, ReportsTheAxesOfItsHandle) {
  for (const bool in_scene : {false, true}) {
    DeviceMemory memory;
    CountingDriver driver;
    driver.can.in_scene = in_scene;
    driver.can.asks_us = !in_scene;
    HandClock clock;
    const DeviceLoop loop(driver, memory, clock, {});
    const DeviceCapabilities can = ProcessDevice(memory).capabilities();
    EXPECT_EQ(can.in_scene, in_scene);
    EXPECT_EQ(can.asks_us, !in_scene);
    EXPECT_EQ(can.freedoms_out, 6);
  }
}

TEST(ProcessDevice, SilentDeviceLeavesTheHandAtRest) {
  Link link;
  link.Begin();
  const Vec3 last = link.controller->Read().X_WA.p;
  Anchor handle;
  for (int i = 0; i < 10; ++i) handle = link.controller->Read();
  EXPECT_EQ(handle.X_WA.p, last);
  EXPECT_TRUE(handle.V_WA.v.isZero());
  EXPECT_GE(link.controller->silent_frames(), ProcessDevice::kSilent);
}

}  // namespace
}  // namespace tandem
