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

/// What a person is told of a rate that `who` claims and that its loop does not follow; empty: it
/// does, or is faster.
std::string WhatRateBecame(const std::string& who, double rate_hz);

/// The work of a device process: one tick reads the handle, tells the controller, waits a bounded
/// while for its answer, and writes to the motor what the guard lets through. So the force that is
/// computed from a tick's input is written in the same tick, and whatever becomes of the
/// controller, the motor is served on time.
class DeviceLoop {
 public:
  static constexpr std::int64_t kPeriodNs = 1'000'000;  // of a device as fast as that, or faster
  static constexpr std::int64_t kWaitNs = 900'000;   // for the answer, from the deadline on
  static constexpr std::int64_t kSpinNs = 40'000;    // of that, without sleeping
  static constexpr std::uint64_t kTellEvery = 1024;  // ticks

  struct Options {
    DeviceLimits users = kUsersDefault;
    bool passivity_control = false;
  };

  /// `driver`, `memory` and `clock` outlive the loop.
  DeviceLoop(Device& driver, DeviceMemory& memory, LoopClock& clock, const Options& options);

  struct Circumstances {
    std::int64_t deadline_ns = 0;  // of this tick
    bool ending = false;           // the process is to end
    bool slept = false;            // the machine slept
  };
  void Tick(const Circumstances& circumstances) noexcept;

  /// For tests: waits in virtual time.
  void SetWait(AnswerWait wait, void* of) noexcept {
    wait_ = wait;
    wait_of_ = of;
  }

  /// The period of a device with a loop of its own of `rate_hz`: as long, in whole milliseconds, at
  /// most four, for an order is too old after five.
  static std::int64_t PeriodOf(double rate_hz) noexcept;
  std::int64_t period_ns() const noexcept { return period_ns_; }

  const MotorGuard& guard() const noexcept { return guard_; }
  /// Whether the motor has none.
  bool at_rest() const noexcept { return given_.f.isZero() && given_.tau.isZero(); }
  DeviceTimes times() const noexcept;
  /// Tells the controller the times so far.
  void Tell() noexcept { memory_->times.Write(times()); }

 private:
  void Say(const Anchor& handle) noexcept;
  /// Takes the newest order; whether it answers this tick.
  bool TakeOrder() noexcept;
  /// Counts what a tick's order was; `first`: that is the first of all.
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
  std::uint64_t answers_ = 0;  // the tick that the newest order answers
  bool started_ = false;
  Wrench given_;
  Histogram read_to_write_;
  std::uint64_t answered_ = 0;
  std::uint64_t unanswered_ = 0;
  std::uint64_t late_ = 0;
  std::uint64_t counted_ = 0;  // the tick that the newest counted order answers
  std::uint64_t missed_ = 0;
  std::int64_t last_deadline_ns_ = 0;
};

}  // namespace tandem
