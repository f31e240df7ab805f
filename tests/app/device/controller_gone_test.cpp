// Tests the device process with a controller that dies or stands still.
#include <algorithm>
#include <chrono>
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
#include "tests/support/machine/lag_meter.h"

namespace tandem {
namespace {

using testing::EmptyLoop;
using testing::Fall;
using testing::FallAfter;
using testing::kClamp;
using testing::kSlew;
using testing::LagMeter;
using testing::Motor;
using testing::Sleep;

/// Returns how often a controller is killed, and how often it is stopped.
int Rounds() {
  const char* requested = std::getenv("TANDEM_DEVICE_KILLS");
  return requested != nullptr ? std::atoi(requested) : 8;
}

/// The rounds of a test, each with a fall of the force: as many as asked for that show something,
/// of those that fit into a minute, but at least as many as asked for. A round shows nothing where
/// the force was gone before the controller, or where the fall came too late and the machine stood
/// still: a loaded machine does both, and it also makes the signal late that ends the controller.
class Falls {
 public:
  /// Returns whether another round is due.
  bool More() const { return begun_ < Rounds() || (shown_ < Rounds() && HasTime()); }
  bool HasTime() const {
    return std::chrono::steady_clock::now() - since_ < std::chrono::minutes(1);
  }

  /// Expects that force began to end within 5 ms and had ended within 20, a tick later at the most.
  /// The lateness of an empty loop in the same round comes on top: the process notices at a tick
  /// that an order is old. Returns whether the round shows something.
  bool Judge(const Fall& fall, double empty_ms, const LagMeter& lag) {
    ++begun_;
    EXPECT_LE(fall.most, kClamp + 1e-9);
    EXPECT_LE(fall.step, kSlew + 1e-9);
    if (fall.held_N == 0) return false;
    EXPECT_GT(fall.damping_ms, 0) << "the force never fell";
    EXPECT_GT(fall.zero_ms, 0) << "the force never ended";
    const bool in_time = fall.damping_ms <= 5 + 1 + empty_ms && fall.zero_ms <= 20 + 1 + empty_ms;
    const double lag_ms = MsOf(lag);
    if (!in_time && std::max(empty_ms, lag_ms) > kStoodStillMs) return false;
    EXPECT_TRUE(in_time) << "fell after " << fall.damping_ms << " ms, ended after " << fall.zero_ms
                         << " ms; an empty loop was late by " << empty_ms
                         << " ms, an ordinary thread by " << lag_ms;
    ++shown_;
    damping_ms_ = std::max(damping_ms_, fall.damping_ms);
    zero_ms_ = std::max(zero_ms_, fall.zero_ms);
    gap_ms_ = std::max(gap_ms_, fall.gap_ms);
    empty_ms_ = std::max(empty_ms_, empty_ms);
    return true;
  }
  /// Expects rounds that show something, and records the worst figures.
  void Finish() const {
    EXPECT_GE(shown_, 1) << "of " << begun_ << " rounds";
    ::testing::Test::RecordProperty("rounds", shown_);
    ::testing::Test::RecordProperty("damping_ms", std::to_string(damping_ms_));
    ::testing::Test::RecordProperty("zero_ms", std::to_string(zero_ms_));
    ::testing::Test::RecordProperty("gap_ms", std::to_string(gap_ms_));
    ::testing::Test::RecordProperty("empty_loop_ms", std::to_string(empty_ms_));
  }

  static double MsOf(const LagMeter& lag) {
    return std::chrono::duration<double, std::milli>(lag.worst()).count();
  }
  static constexpr double kStoodStillMs = 2;

 private:
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  int begun_ = 0;
  int shown_ = 0;
  double damping_ms_ = 0, zero_ms_ = 0, gap_ms_ = 0, empty_ms_ = 0;  // the worst
};

TEST(DeviceProcess, KilledControllersForceEndsInTime) {
  const TemporaryFolder folder;
  std::mt19937 random(1);
  Falls falls;
  for (int round = 0; falls.More(); ++round) {
    const std::filesystem::path file = folder.path() / ("motor" + std::to_string(round));
    const Motor motor(file);
    Result<ChildProcess> scripted =
        ChildProcess::Start({TANDEM_SCRIPTED_CONTROLLER, "fake:record=" + file.string()});
    ASSERT_TRUE(scripted);
    ASSERT_TRUE(motor.WaitForForce(1.0, 60));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    const LagMeter lag;
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    scripted->Signal(SIGKILL);
    motor.WaitForTheFall();
    falls.Judge(FallAfter(motor.WritesSince(seen - 20), gone_ns), empty.WorstMs(), lag);
    EXPECT_EQ(motor.force(), 0);
    EXPECT_TRUE(motor.WaitForNoWrites()) << "the device process outlives its controller";
    std::filesystem::remove(file);
  }
  falls.Finish();
}

// The test is the parent of the device process and lives on, so nobody tells that process that its
// controller is gone. The age of its orders alone ends the force.
TEST(DeviceProcess, UnreportedControllerEndStopsTheForceInTime) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "motor";
  std::mt19937 random(3);
  Falls falls;
  int judged = 0;
  const Motor motor(file);
  const auto process = DeviceProcess::Start({.driver = "fake:record=" + file.string()});
  ASSERT_TRUE(process);
  const std::string memory = std::to_string((*process)->descriptor());
  Result<SharedMemory> shared =
      SharedMemory::Attach(dup((*process)->descriptor()), sizeof(DeviceMemory));
  ASSERT_TRUE(shared);
  const auto& orders = static_cast<const DeviceMemory*>(shared->data())->order;
  while (falls.More() || (judged < Rounds() / 4 && falls.HasTime())) {
    Result<ChildProcess> scripted = ChildProcess::Start(
        {TANDEM_SCRIPTED_CONTROLLER, "--memory", memory}, (*process)->descriptor());
    ASSERT_TRUE(scripted);
    ASSERT_TRUE(motor.WaitForForce(1.0, 60));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    const LagMeter lag;
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const auto zeroed = (*process)->Newest()->counts.zeroed;
    const std::int64_t gone_ns = MonotonicNowNs();
    scripted->Signal(SIGKILL);
    motor.WaitForTheFall();
    const Fall fall = FallAfter(motor.WritesSince(seen - 20), gone_ns);
    const double empty_ms = empty.WorstMs();
    const bool shown = falls.Judge(fall, empty_ms, lag);
    EXPECT_EQ(motor.force(), 0);
    // its own rule ended the force, which fell when the input of the last order was five
    // milliseconds old, however long before its end the controller gave that order. Another rule
    // may have been first where the machine stood still, or where the end came as an order was
    // written
    DeviceOrder last;
    const bool stood_still = std::max(empty_ms, Falls::MsOf(lag)) > Falls::kStoodStillMs;
    const bool by_another_rule = (*process)->Newest()->counts.zeroed != zeroed;
    if (!shown || stood_still || by_another_rule || !orders.Read(last)) continue;
    ++judged;
    EXPECT_GE(fall.damping_ms + 1e-6 * static_cast<double>(gone_ns - last.input_ns), 5);
    EXPECT_EQ((*process)->Newest()->state, static_cast<std::uint8_t>(SafetyState::kExpired));
  }
  EXPECT_GE(judged, 1);
  falls.Finish();
}

TEST(DeviceProcess, StoppedControllersForceEndsInTimeAndReturns) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "motor";
  std::mt19937 random(2);
  Falls falls;
  const Motor motor(file);
  Result<ChildProcess> scripted =
      ChildProcess::Start({TANDEM_SCRIPTED_CONTROLLER, "fake:record=" + file.string()});
  ASSERT_TRUE(scripted);
  while (falls.More()) {
    ASSERT_TRUE(motor.WaitForForce(0.9, 60));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    const LagMeter lag;
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    scripted->Signal(SIGSTOP);
    motor.WaitForTheFall();
    EXPECT_EQ(motor.force(), 0);
    falls.Judge(FallAfter(motor.WritesSince(seen - 20), gone_ns), empty.WorstMs(), lag);
    scripted->Signal(SIGCONT);
  }
  EXPECT_TRUE(motor.WaitForForce(2.0, 60)) << "the force comes back";
  falls.Finish();
}

}  // namespace
}  // namespace tandem
