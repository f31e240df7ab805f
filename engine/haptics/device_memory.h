#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "engine/haptics/device.h"
#include "engine/realtime/doorbell.h"
#include "engine/realtime/seqlock.h"
#include "engine/safety/motor_guard.h"

namespace tandem {

/// The report of one tick of a device: the state of its handle and of its guard.
struct DeviceTick {
  std::uint64_t tick = 0;        // from 1 on
  std::int64_t input_ns = 0;     // time at which the handle was read, monotonic
  std::array<double, 7> X_WD{};  // quaternion x y z w, then the position in m
  std::array<double, 6> V_WD{};  // rad/s, then m/s
  std::uint8_t state = 0;        // SafetyState
  bool failed = false;
  bool clutch_button = false;
  SafetyCounts counts;
  PassivityAccount passivity;
};

/// The controller's order to the device. The counters are those of MotorOrder.
struct DeviceOrder {
  std::uint64_t tick = 0;  // tick whose input it answers
  std::int64_t input_ns = 0;
  std::array<double, 6> F_D_W{};  // N m, then N
  std::uint32_t ramps = 0;
  std::uint32_t stops = 0;
  std::uint32_t resumes = 0;
  std::uint32_t started = 0;  // Device::Start()
};

/// Times of a device's ticks, ns.
struct DeviceTimes {
  std::uint64_t ticks = 0;
  std::uint64_t answered = 0;    // answered in the tick of their input
  std::uint64_t unanswered = 0;  // unanswered although orders were coming
  std::uint64_t late = 0;        // answers in a later tick
  std::uint64_t missed = 0;
  std::int64_t read_to_write_p50_ns = 0;
  std::int64_t read_to_write_p99_ns = 0;
  std::int64_t read_to_write_max_ns = 0;  // counts all answers, including late ones
  // for a device whose vendor's thread fetches the force: age of that, short by less than its
  // period
  std::uint64_t requested = 0;
  std::int64_t asked_mean_ns = 0;
  std::int64_t asked_max_ns = 0;

  /// Returns the share of unanswered ticks among those in which orders were coming.
  double unanswered_share() const noexcept {
    const std::uint64_t all = answered + unanswered;
    return all == 0 ? 0.0 : static_cast<double>(unanswered) / static_cast<double>(all);
  }
};

/// The memory that a controller and the process of a device share: the newest value in both
/// directions, without locks. The controller makes it and writes `home`. The device process writes
/// all fields before `ready` once.
struct DeviceMemory {
  static constexpr std::uint64_t kVersion = 0x7461'6e64'656d'0003;  // "tandem", 3

  std::uint64_t version = 0;
  /// Pose of the handle in W: that of a body that the hand is about to hold.
  std::array<double, 7> home{};
  std::array<double, 16> capabilities{};
  std::array<double, 2> limits{};  // N, N m in force
  std::int64_t origin_ns = 0;      // deadline of a tick: the others are whole periods away
  std::int64_t period_ns = 0;
  std::array<char, 256> fault{};     // reason why there is no device, in a line
  std::array<char, 16> scheduler{};  // scheduler of the loop's thread
  std::array<char, 512>
      warning{};  // a line that says what that thread was not granted; empty: nothing
  enum Ready : std::uint32_t { kNotYet, kReady, kFailed };
  std::atomic<std::uint32_t> ready{kNotYet};
  Doorbell tick_bell;
  Doorbell order_bell;
  Seqlock<DeviceTick> tick;
  Seqlock<DeviceOrder> order;
  Seqlock<DeviceTimes> times;
  Seqlock<std::array<char, 320>> trouble;  // trouble of the device, in a line; empty: none
};

std::array<double, 7> AsNumbers(const Pose& pose) noexcept;
Pose AsPose(const std::array<double, 7>& numbers) noexcept;
std::array<double, 16> AsNumbers(const DeviceCapabilities& capabilities) noexcept;
DeviceCapabilities AsCapabilities(const std::array<double, 16>& numbers) noexcept;

}  // namespace tandem
