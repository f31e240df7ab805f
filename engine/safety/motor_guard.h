#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/safety/device_limits.h"
#include "engine/safety/mean_limit.h"
#include "engine/safety/passivity_observer.h"
#include "engine/safety/safety_state.h"

namespace tandem {

/// The newest order of the controller to a motor. The counters grow with each request, so that no
/// request is lost although only the newest order is read.
struct MotorOrder {
  /// Time at which the input that it answers was read; negative: none has come.
  std::int64_t input_ns = -1;
  Wrench F_D_W;               // wrench on the handle, about its origin
  std::uint32_t ramps = 0;    // ramp-ins requested: at the start and after an error
  std::uint32_t stops = 0;    // emergency stops
  std::uint32_t resumes = 0;  // ends of emergency stops
};

/// The device's own report in a tick.
struct MotorInput {
  std::int64_t now_ns = 0;
  Vec3 p_WD = Vec3::Zero();  // position of the handle
  Twist V_WD;
  bool failed = false;       // the driver is in trouble
  bool stop_button = false;  // pressed
  bool ending = false;       // the process is about to end
  bool slept = false;        // the machine slept since the last tick
};

/// The last guard before a motor, in the process that has the device in hand. Whatever happens to
/// the controller, to the driver or to time, the motor gets a finite wrench within its limits. The
/// wrench changes by at most its slew from one tick to the next. It is zero once its sources are
/// gone. docs/decisions/0033-safety.md has the reason of each number.
///
/// A state machine that gets the time as input and reads no clock. It does not allocate, lock or
/// throw. Used by the thread that writes to the motor.
class MotorGuard {
 public:
  static constexpr std::int64_t kDampingNs = 5'000'000;  // age from which on there is damping only
  /// Age from which on there is no damping either.
  static constexpr std::int64_t kFadeNs = 12'000'000;
  /// Age from which on there is no force, until a ramp-in.
  static constexpr std::int64_t kZeroNs = 20'000'000;
  static constexpr std::int64_t kMostGapNs = 20'000'000;  // between two ticks of a loop that runs
  static constexpr std::int64_t kShortRampNs = 100'000'000;  // ramp after a few late orders
  static constexpr std::int64_t kRampNs = 1'000'000'000;  // ramp at the start, and after all else
  static constexpr double kMostSpeed = 1.0;               // m/s
  static constexpr double kMostTurn = 20.0;               // rad/s
  static constexpr double kSlowAgain = 0.5;  // share of either, below which the state ends
  static constexpr double kSlewTicks = 6.0;  // ticks of a millisecond from nothing to the limit
  static constexpr std::int64_t kLeastPeriodNs = 1'000'000;
  static constexpr std::int64_t kMostPeriodNs = 4'000'000;
  static constexpr double kDamping = 2.0;           // N s/m, while no fresh order comes
  static constexpr double kMostDampingShare = 0.2;  // share of the limit

  struct Options {
    DeviceLimits limits;                      // peak, as claimed; reduced to the limits for a hand
    DeviceLimits continuous;                  // limits for ever, as claimed
    double damping = kDamping;                // damping that the device bears, N s/m
    bool passivity_control = false;           // pays an active port's debt back by damping
    std::int64_t period_ns = kLeastPeriodNs;  // period of the ticks
  };

  explicit MotorGuard(const Options& options) noexcept;

  /// Returns the wrench that the motor may get; called once a tick, right before the write.
  Wrench Pass(const MotorInput& input, const MotorOrder& order) noexcept;

  /// Returns when an order that answers an input of `input_ns` is too old: waiting for a fresh
  /// order ends then.
  static constexpr std::int64_t ExpiryOf(std::int64_t input_ns) noexcept {
    return input_ns < 0 ? 0 : input_ns + kDampingNs;
  }

  SafetyState state() const noexcept { return state_; }
  const SafetyCounts& counts() const noexcept { return counts_; }
  const DeviceLimits& limits() const noexcept { return limits_; }
  /// Returns the greatest change of force (N) and moment (N m) in a tick.
  DeviceLimits slew() const noexcept {
    const double ms = 1e-6 * static_cast<double>(options_.period_ns);
    return {limits_.force * ms / kSlewTicks, limits_.moment * ms / kSlewTicks};
  }
  const PassivityObserver& passivity() const noexcept { return passivity_; }
  /// Returns the ticks in which the passivity control damped.
  std::uint64_t damped() const noexcept { return damped_; }
  bool passivity_control() const noexcept { return options_.passivity_control; }

 private:
  /// Finds the state of this tick; counts the events that end a force.
  void Judge(const MotorInput& input, const MotorOrder& order) noexcept;
  /// Tells whether the handle is too fast, or has been and is not slow again, whatever the state.
  bool TooFast(const MotorInput& input) noexcept;
  /// Enters a state without force, unless a graver state holds; counts it.
  void Latch(SafetyState state) noexcept;
  /// Begins the ramp of a second.
  void Ramp(std::int64_t now_ns) noexcept;
  /// Returns the smaller of the shares of both ramps.
  double RampShare(std::int64_t now_ns) const noexcept;
  /// Returns the wrench that the state allows.
  Wrench Wanted(const MotorInput& input, const MotorOrder& order) const noexcept;

  Options options_;
  DeviceLimits limits_;
  bool fast_ = false;
  MeanLimit mean_force_;
  MeanLimit mean_moment_;
  PassivityObserver passivity_;
  SafetyState state_ = SafetyState::kOff;
  SafetyCounts counts_;
  Wrench last_;
  std::int64_t last_ns_ = -1;
  // starts of the ramp of a second, without the time of late orders, and of the short ramp after
  // these
  std::int64_t ramp_begin_ns_ = 0;
  std::int64_t short_begin_ns_ = 0;
  std::int64_t ramped_ns_ = 0;  // how far the former ramp had come when orders were late
  std::uint64_t damped_ = 0;
  std::uint32_t ramps_ = 0;  // counter in the last order, as the next two
  std::uint32_t stops_ = 0;
  std::uint32_t resumes_ = 0;
  bool late_ = false;  // the order of the last tick was late
  bool pressed_ = false;
  bool hard_ = false;  // the output falls at once
  // places of the handle in the last ticks: a driver's own speed may be wrong
  struct Place {
    std::int64_t ns = -1;
    Vec3 p_WD = Vec3::Zero();
  };
  std::array<Place, 16> places_{};
  std::size_t place_ = 0;
};

}  // namespace tandem
