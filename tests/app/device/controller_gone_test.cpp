// Tests the device process with a controller that dies or stands still.
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "app/process/child_processes.h"
#include "app/process/device_process.h"
#include "engine/haptics/process_device.h"
#include "tests/app/device/motor_writes.h"

namespace tandem {
namespace {

using testing::EmptyLoop;
using testing::Fall;
using testing::FallAfter;
using testing::kClamp;
using testing::kSlew;
using testing::Motor;
using testing::Sleep;

/// Returns how often a controller is killed, and how often it is stopped.
int Rounds() {
  const char* requested = std::getenv("TANDEM_DEVICE_KILLS");
  return requested != nullptr ? std::atoi(requested) : 8;
}

/// The worst figures of many falls.
struct Worst {
  double damping_ms = 0, zero_ms = 0, gap_ms = 0, empty_ms = 0;
  void Add(const Fall& fall, double empty) {
    damping_ms = std::max(damping_ms, fall.damping_ms);
    zero_ms = std::max(zero_ms, fall.zero_ms);
    gap_ms = std::max(gap_ms, fall.gap_ms);
    empty_ms = std::max(empty_ms, empty);
  }
};

/// Expects that force began to end within 5 ms and had ended within 20, a tick later at the most.
/// The lateness of an empty loop in the same round comes on top: the process notices at a tick that
/// an order is old.
void ExpectInTime(const Fall& fall, double empty_ms) {
  EXPECT_GT(fall.damping_ms, 0) << "the force never fell";
  EXPECT_LE(fall.damping_ms, 5 + 1 + empty_ms);
  EXPECT_GT(fall.zero_ms, 0) << "the force never ended";
  EXPECT_LE(fall.zero_ms, 20 + 1 + empty_ms);
  EXPECT_LE(fall.most, kClamp + 1e-9);
  EXPECT_LE(fall.step, kSlew + 1e-9);
}

void RecordWorst(const Worst& worst) {
  ::testing::Test::RecordProperty("damping_ms", std::to_string(worst.damping_ms));
  ::testing::Test::RecordProperty("zero_ms", std::to_string(worst.zero_ms));
  ::testing::Test::RecordProperty("gap_ms", std::to_string(worst.gap_ms));
  ::testing::Test::RecordProperty("empty_loop_ms", std::to_string(worst.empty_ms));
}

TEST(DeviceProcess, KilledControllersForceEndsInTime) {
  const TemporaryFolder folder;
  std::mt19937 random(1);
  Worst worst;
  for (int round = 0; round < Rounds(); ++round) {
    const std::filesystem::path file = folder.path() / ("motor" + std::to_string(round));
    const Motor motor(file);
    Result<ChildProcess> scripted =
        ChildProcess::Start({TANDEM_SCRIPTED_CONTROLLER, "fake:record=" + file.string()});
    ASSERT_TRUE(scripted);
    ASSERT_TRUE(motor.WaitForForce(1.0));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    scripted->Signal(SIGKILL);
    Sleep(0.06);
    const Fall fall = FallAfter(motor.WritesSince(seen - 20), gone_ns);
    const double empty_ms = empty.WorstMs();
    ExpectInTime(fall, empty_ms);
    worst.Add(fall, empty_ms);
    // the device process ends by itself: nothing is left behind
    const std::uint64_t written = motor.count();
    Sleep(0.02);
    EXPECT_LE(motor.count(), written + 1);
    std::filesystem::remove(file);
  }
  RecordWorst(worst);
}

// The test is the parent of the device process and lives on, so nobody tells that process that its
// controller is gone. The age of its orders alone ends the force.
TEST(DeviceProcess, UnreportedControllerEndStopsTheForceInTime) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "motor";
  std::mt19937 random(3);
  Worst worst;
  int judged = 0;
  const Motor motor(file);
  const auto process = DeviceProcess::Start({.driver = "fake:record=" + file.string()});
  ASSERT_TRUE(process);
  const std::string memory = std::to_string((*process)->descriptor());
  Result<SharedMemory> shared =
      SharedMemory::Attach(dup((*process)->descriptor()), sizeof(DeviceMemory));
  ASSERT_TRUE(shared);
  const auto& orders = static_cast<const DeviceMemory*>(shared->data())->order;
  for (int round = 0; round < Rounds(); ++round) {
    Result<ChildProcess> scripted = ChildProcess::Start(
        {TANDEM_SCRIPTED_CONTROLLER, "--memory", memory}, (*process)->descriptor());
    ASSERT_TRUE(scripted);
    ASSERT_TRUE(motor.WaitForForce(1.0));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    scripted->Signal(SIGKILL);
    Sleep(0.06);
    const Fall fall = FallAfter(motor.WritesSince(seen - 20), gone_ns);
    const double empty_ms = empty.WorstMs();
    ExpectInTime(fall, empty_ms);
    worst.Add(fall, empty_ms);
    // its own rule ended the force, which fell when the input of the last order was five
    // milliseconds old, however long before its end the controller gave that order. Another rule
    // may have been first where the machine stood still, or where the end came as an order was
    // written
    DeviceOrder last;
    if (empty_ms > 2 || !orders.Read(last)) continue;
    ++judged;
    EXPECT_GE(fall.damping_ms + 1e-6 * static_cast<double>(gone_ns - last.input_ns), 5);
    EXPECT_EQ((*process)->Newest()->state, static_cast<std::uint8_t>(SafetyState::kExpired));
  }
  EXPECT_GE(judged, Rounds() / 4);
  RecordWorst(worst);
}

TEST(DeviceProcess, StoppedControllersForceEndsInTimeAndReturns) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "motor";
  std::mt19937 random(2);
  Worst worst;
  const Motor motor(file);
  Result<ChildProcess> scripted =
      ChildProcess::Start({TANDEM_SCRIPTED_CONTROLLER, "fake:record=" + file.string()});
  ASSERT_TRUE(scripted);
  for (int round = 0; round < Rounds(); ++round) {
    ASSERT_TRUE(motor.WaitForForce(0.9));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    scripted->Signal(SIGSTOP);
    Sleep(0.05);
    const Fall fall = FallAfter(motor.WritesSince(seen - 20), gone_ns);
    scripted->Signal(SIGCONT);
    const double empty_ms = empty.WorstMs();
    ExpectInTime(fall, empty_ms);
    worst.Add(fall, empty_ms);
    EXPECT_EQ(motor.force(), 0);
  }
  EXPECT_TRUE(motor.WaitForForce(2.4, 60));
  RecordWorst(worst);
}

}  // namespace
}  // namespace tandem
