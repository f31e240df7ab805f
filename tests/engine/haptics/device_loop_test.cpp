// Tests a device's loop and a controller's end of it, in one thread and in virtual time.
#include "engine/haptics/device_loop.h"

#include <algorithm>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "engine/haptics/process_device.h"
#include "tests/engine/haptics/device_link.h"

namespace tandem {
namespace {

using testing::CountingDriver;
using testing::HandClock;
using testing::kPeriod;
using testing::Link;

TEST(DeviceLoop, ForceIsWrittenInTheTickOfItsInput) {
  Link link;
  link.Begin();
  ASSERT_EQ(link.state(), SafetyState::kOn);
  for (int i = 0; i < 500; ++i) {
    link.Tick();
    EXPECT_NEAR(link.driver.given.f.x(), 1e-3 * (link.driver.reads % 1000), 1e-9);
  }
  const DeviceTimes times = link.loop->times();
  EXPECT_GE(times.answered, 1700U);
  EXPECT_LE(times.unanswered, 1U);
  EXPECT_NEAR(static_cast<double>(times.read_to_write_max_ns), kPeriod / 4, kPeriod / 64);
}

// The controller is one tick behind now and then: its bell rings for the tick before.
TEST(DeviceLoop, EarlierTicksNotificationDoesNotEndTheWait) {
  Link link;
  link.stray_ring = true;
  link.Begin();
  for (int i = 0; i < 500; ++i) {
    link.Tick();
    EXPECT_NEAR(link.driver.given.f.x(), 1e-3 * (link.driver.reads % 1000), 1e-9);
  }
  EXPECT_LE(link.loop->times().unanswered, 1U);
}

// An answer that takes 1.25 ms comes in the tick after: it counts, with all the time that it took.
TEST(DeviceLoop, LateAnswersAreCountedWithTheirTrueAge) {
  Link link;
  link.Begin();
  ASSERT_LE(link.loop->times().read_to_write_max_ns, kPeriod);
  const std::uint64_t unanswered = link.loop->times().unanswered;
  link.answer_ns = 10 * kPeriod;  // nothing within the wait: Tick() answers after it
  link.Ticks(100);
  const DeviceTimes times = link.loop->times();
  EXPECT_GE(times.late, 99U);
  EXPECT_EQ(times.unanswered, unanswered + 100);
  EXPECT_GE(times.read_to_write_max_ns, kPeriod);
  EXPECT_LE(times.read_to_write_max_ns, 2 * kPeriod);
}

TEST(DeviceLoop, HandleIsTimestampedAtTheStartOfItsRead) {
  Link link;
  link.Begin();
  link.driver.clock = &link.clock;
  link.driver.read_ns = 6 * kPeriod;
  link.Tick(false);
  DeviceTick tick;
  ASSERT_TRUE(link.memory->tick.Read(tick));
  EXPECT_EQ(link.clock.now_ns - kPeriod, tick.input_ns);
  // an answer to the tick before is more than five milliseconds old by now
  EXPECT_EQ(link.state(), SafetyState::kDamping);
}

TEST(DeviceLoop, SlowDeviceSetsTheTickRate) {
  EXPECT_EQ(DeviceLoop::PeriodOf(1000), kPeriod);
  EXPECT_EQ(DeviceLoop::PeriodOf(4000), kPeriod);
  EXPECT_EQ(DeviceLoop::PeriodOf(999.9), kPeriod);
  EXPECT_EQ(DeviceLoop::PeriodOf(700), 2 * kPeriod);
  EXPECT_EQ(DeviceLoop::PeriodOf(500), 2 * kPeriod);
  EXPECT_EQ(DeviceLoop::PeriodOf(30), 4 * kPeriod);
  EXPECT_EQ(DeviceLoop::PeriodOf(std::numeric_limits<double>::quiet_NaN()), kPeriod);
  EXPECT_EQ(DeviceLoop::PeriodOf(-1), kPeriod);
}

TEST(DeviceLoop, SlowDeviceFollowsTheSameForceRamps) {
  for (const double rate_hz : {500.0, 250.0}) {
    Link link(rate_hz);
    const auto every = static_cast<int>(link.loop->period_ns() / kPeriod);
    link.Ticks(3);
    link.controller->Start();
    link.Ticks(1100 / every);
    ASSERT_EQ(link.state(), SafetyState::kOn);
    link.Ticks(200 / every);
    EXPECT_EQ(link.state(), SafetyState::kOn);
    EXPECT_GT(link.driver.given.f.x(), 0.01);
    link.Ticks(24 / every, false);
    EXPECT_EQ(link.state(), SafetyState::kExpired);
    EXPECT_TRUE(link.driver.given.f.isZero());
    link.Ticks(110);
    EXPECT_EQ(link.state(), SafetyState::kRamping);
    // six milliseconds from nothing to the limit, whatever the ticks
    EXPECT_NEAR(link.loop->guard().slew().force, 12.0 / 6 * every, 1e-12);
  }
}

TEST(DeviceLoop, NoForceBeforeStart) {
  Link link;
  link.Ticks(50);
  EXPECT_FALSE(link.driver.started);
  EXPECT_TRUE(link.driver.given.f.isZero());
  EXPECT_EQ(link.state(), SafetyState::kOff);
  link.controller->Start();
  link.Ticks(3);
  EXPECT_TRUE(link.driver.started);
  EXPECT_EQ(link.state(), SafetyState::kRamping);
}

TEST(DeviceLoop, LostControllerMeansDampingAfter5MillisecondsAndNoForceAfter20) {
  Link link;
  link.Begin();
  const double before = link.driver.given.f.x();
  ASSERT_GT(before, 0.1);
  const std::int64_t last_ns = link.clock.now_ns - kPeriod;  // when the last answered tick was read
  link.Ticks(4, false);
  EXPECT_EQ(link.state(), SafetyState::kOn);
  link.Tick(false);
  // the wait for an answer ends when the last one is five milliseconds old
  EXPECT_EQ(link.state(), SafetyState::kDamping);
  EXPECT_LE(link.clock.now_ns - kPeriod - last_ns, MotorGuard::kDampingNs);
  link.Ticks(15, false);
  EXPECT_TRUE(link.driver.given.f.isZero());
  EXPECT_EQ(link.state(), SafetyState::kExpired);
}

TEST(DeviceLoop, OrderHasTheAgeOfItsInput) {
  Link link;
  link.Begin();
  // it goes on publishing, always the answer to one tick
  DeviceOrder stuck;
  ASSERT_TRUE(link.memory->order.Read(stuck));
  for (int i = 0; i < 25; ++i) {
    link.memory->order.Write(stuck);
    link.Tick(false);
  }
  EXPECT_EQ(link.state(), SafetyState::kExpired);
  // an answer to a tick that has not come yet counts as none
  stuck.tick += 1000;
  stuck.input_ns += 1'000'000'000;
  stuck.ramps += 1;
  link.memory->order.Write(stuck);
  link.Tick(false);
  EXPECT_TRUE(link.driver.given.f.isZero());
}

TEST(DeviceLoop, OnlyLatenessRecoversWithoutAPerson) {
  Link link;
  link.Begin();
  link.Ticks(30, false);
  ASSERT_EQ(link.state(), SafetyState::kExpired);
  link.Ticks(90);
  EXPECT_EQ(link.state(), SafetyState::kExpired);
  link.Ticks(20);
  EXPECT_EQ(link.state(), SafetyState::kRamping);
  link.Ticks(1100);
  EXPECT_EQ(link.state(), SafetyState::kOn);

  link.driver.in_trouble = true;
  link.Ticks(5);
  link.driver.in_trouble = false;
  link.Ticks(500);
  EXPECT_EQ(link.state(), SafetyState::kFault);
  link.controller->Resume();
  link.Ticks(1200);
  EXPECT_EQ(link.state(), SafetyState::kOn);
}

TEST(DeviceLoop, EmergencyStopReachesTheMotorInTheSameTick) {
  Link link;
  link.force_at_micrometre = 12;
  link.Begin();
  ASSERT_GT(link.driver.given.f.x(), 1);
  link.controller->Stop();
  link.Tick();
  EXPECT_EQ(link.state(), SafetyState::kStopped);
  link.Ticks(6);
  EXPECT_TRUE(link.driver.given.f.isZero());
  link.Ticks(300);
  EXPECT_EQ(link.controller->safety().state, SafetyState::kStopped);
  EXPECT_EQ(link.controller->safety().counts.stops, 1U);
  link.controller->Resume();
  link.Ticks(1200);
  EXPECT_EQ(link.state(), SafetyState::kOn);
}

TEST(DeviceLoop, ControllerReceivesTheActiveLimits) {
  DeviceMemory memory;
  CountingDriver driver;
  driver.can.peak = {std::numeric_limits<double>::quiet_NaN(), 0.7};
  driver.can.stiffness = 600;
  driver.can.freedoms_out = 3;
  driver.can.asks_us = true;
  driver.can.workspace.Add(Vec3(-0.1, -0.2, -0.3));
  driver.can.workspace.Add(Vec3(0.1, 0.2, 0.3));
  HandClock clock;
  const DeviceLoop loop(driver, memory, clock, {{5, 0.2}});
  const ProcessDevice controller(memory);
  const DeviceCapabilities can = controller.capabilities();
  EXPECT_EQ(can.peak.force, 0);
  EXPECT_EQ(can.peak.moment, 0.2);
  EXPECT_EQ(can.stiffness, 600);
  EXPECT_EQ(can.freedoms_in, 6);
  EXPECT_EQ(can.freedoms_out, 3);
  EXPECT_TRUE(can.asks_us);
  EXPECT_EQ(can.workspace.min, Vec3(-0.1, -0.2, -0.3));
}

TEST(DeviceLoop, MotorlessDeviceReceivesTheUserLimitedForce) {
  for (const double users : {5.0, 1.0}) {
    auto memory = std::make_unique<DeviceMemory>();
    CountingDriver driver;
    driver.can.freedoms_out = 0;
    driver.can.peak = {0, 0};  // it claims none
    HandClock clock;
    DeviceLoop loop(driver, *memory, clock, {{users, 0.2}});
    loop.SetWait(
        [](void* of, std::uint32_t, std::int64_t until_ns) {
          static_cast<HandClock*>(of)->now_ns = until_ns;
        },
        &clock);
    ProcessDevice controller(*memory);
    for (int i = 1; i <= 1500; ++i) {
      if (i == 3) controller.Start();
      clock.now_ns = i * kPeriod;
      loop.Tick({.deadline_ns = clock.now_ns});
      controller.Read();
      controller.Render({Vec3::Zero(), Vec3(50, 0, 0)});
    }
    // the force is at least what lets a handle give way, for it moves no motor
    EXPECT_NEAR(driver.given.f.x(), std::max(users, kUsersDefault.force), 1e-9);
  }
}

// A handle without motors that heard no force would run ahead of a part that contact holds up.
TEST(DeviceLoop, FaultOfAMotorlessDeviceKeepsTheForce) {
  for (const int motors : {0, 6}) {
    Link link(1000, motors);
    link.force_at_micrometre = 1e3;  // more than the limit in any tick
    link.Begin();
    link.driver.in_trouble = true;  // unplugged
    link.Ticks(50);
    link.driver.in_trouble = false;
    link.Ticks(1200);
    EXPECT_EQ(link.state(), motors == 0 ? SafetyState::kOn : SafetyState::kFault);
    EXPECT_NEAR(link.driver.given.f.x(), motors == 0 ? 12 : 0, 1e-9);
  }
}

}  // namespace
}  // namespace tandem
