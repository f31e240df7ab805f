#pragma once

#include <cstdint>
#include <string>

#include "engine/haptics/device_memory.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/histogram.h"
#include "engine/safety/motor_guard.h"

namespace tandem {

/// Waits for the controller's answer: until the order's bell has rung since `seen`, or `until_ns`.
using AnswerWait = void (*)(void* of, std::uint32_t seen, std::int64_t until_ns);

/// Returns a text for a person on a rate that `who` claims and that its loop does not follow; empty
/// if it does, or if the device is faster.
std::string DescribeRateChange(const std::string& who, double rate_hz);

/// The work of a device process. A tick reads the handle, informs the controller, waits a bounded
/// time for its answer, and writes to the motor what the guard passes. So the force that is
/// computed from a tick's input is written in the same tick. Whatever happens to the controller,
/// the motor gets its force on time.
class DeviceLoop {
 public:
  /// Period of a device that is as fast as that, or faster.
  static constexpr std::int64_t kPeriodNs = 1'000'000;
  static constexpr std::int64_t kWaitNs = 900'000;   // wait for the answer, from the deadline on
  static constexpr std::int64_t kSpinNs = 40'000;    // part of the wait without sleeping
  static constexpr std::uint64_t kTellEvery = 1024;  // ticks

  struct Options {
    DeviceLimits users = kUsersDefault;
    bool passivity_control = false;
  };

  /// `driver`, `memory` and `clock` must outlive the loop.
  DeviceLoop(Device& driver, DeviceMemory& memory, LoopClock& clock, const Options& options);

  struct TickConditions {
    std::int64_t deadline_ns = 0;  // deadline of this tick
    bool ending = false;           // the process is about to end
    bool slept = false;            // the machine slept
  };
  void Tick(const TickConditions& circumstances) noexcept;

  /// Replaces the wait, for tests in virtual time.
  void SetWait(AnswerWait wait, void* of) noexcept {
    wait_ = wait;
    wait_of_ = of;
  }

  /// Returns the loop's period for a device with its own loop of `rate_hz`: as long, in whole
  /// milliseconds. It is at most four, because an order is too old after five.
  static std::int64_t PeriodOf(double rate_hz) noexcept;
  std::int64_t period_ns() const noexcept { return period_ns_; }

  const MotorGuard& guard() const noexcept { return guard_; }
  /// Tells whether the motor has no force.
  bool at_rest() const noexcept { return given_.f.isZero() && given_.tau.isZero(); }
  DeviceTimes times() const noexcept;
  /// Writes the times so far for the controller.
  void PublishTimes() noexcept { memory_->times.Write(times()); }

 private:
  void PublishTick(const Anchor& handle) noexcept;
  /// Takes the newest order; returns whether it answers this tick.
  bool TakeOrder() noexcept;
  /// Counts a tick's order. `first`: it is the first of all.
  void Count(bool answered, bool first) noexcept;

  Device* driver_;
  DeviceMemory* memory_;
  LoopClock* clock_;
  std::int64_t period_ns_;
  bool has_motors_;
  MotorGuard guard_;
  AnswerWait wait_ = nullptr;
  void* wait_of_ = nullptr;
  DeviceTick tick_;
  MotorOrder order_;
  std::uint64_t answers_ = 0;  // tick that the newest order answers
  bool started_ = false;
  Wrench given_;
  Histogram read_to_write_;
  std::uint64_t answered_ = 0;
  std::uint64_t unanswered_ = 0;
  std::uint64_t late_ = 0;
  std::uint64_t counted_ = 0;  // tick that the newest counted order answers
  std::uint64_t missed_ = 0;
  std::int64_t last_deadline_ns_ = 0;
};

}  // namespace tandem
