#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/safety/device_limits.h"
#include "engine/safety/mean_limit.h"
#include "engine/safety/passivity_observer.h"
#include "engine/safety/safety_state.h"

namespace tandem {

/// The newest that the controller wants of a motor. The counters grow with each request, so that
/// none is lost where only the newest order is read.
struct MotorOrder {
  std::int64_t input_ns = -1;  // when the input was read that it answers; negative: none came yet
  Wrench F_D_W;                // on the handle, about its origin
  std::uint32_t ramps = 0;     // ramp-ins asked for: at the start and after an error
  std::uint32_t stops = 0;     // emergency stops
  std::uint32_t resumes = 0;   // ends of them
};

/// What the device itself says in a tick.
struct MotorInput {
  std::int64_t now_ns = 0;
  Vec3 p_WD = Vec3::Zero();  // of the handle
  Twist V_WD;
  bool failed = false;       // the driver is in trouble
  bool stop_button = false;  // pressed
  bool ending = false;       // the process is to end
  bool slept = false;        // the machine slept since the last tick
};

/// The last thing before a motor, in the process that has the device in hand. Whatever happens to
/// the controller, to the driver or to time, the motor gets a finite wrench within its limits that
/// changes by at most its slew from one tick to the next, and none at all once what it would rest
/// on is gone. docs/decisions/0033-safety.md has the reason of each number.
///
/// A state machine that is fed with the time and reads no clock. It allocates, locks and throws
/// nothing. Used by the thread that writes to the motor.
class MotorGuard {
 public:
  static constexpr std::int64_t kDampingNs = 5'000'000;   // old: damping only from here on
  static constexpr std::int64_t kFadeNs = 12'000'000;     // older: not even that is asked for
  static constexpr std::int64_t kZeroNs = 20'000'000;     // older: nothing, until a ramp-in
  static constexpr std::int64_t kMostGapNs = 20'000'000;  // between two ticks of a loop that runs
  static constexpr std::int64_t kShortRampNs = 100'000'000;  // after a few late orders
  static constexpr std::int64_t kRampNs = 1'000'000'000;     // at the start, after all else
  static constexpr double kMostSpeed = 1.0;                  // m/s
  static constexpr double kMostTurn = 20.0;                  // rad/s
  static constexpr double kSlowAgain = 0.5;                  // share of either, below which it ends
  static constexpr double kSlewTicks = 6.0;  // of a millisecond, from nothing to the limit
  static constexpr std::int64_t kLeastPeriodNs = 1'000'000;
  static constexpr std::int64_t kMostPeriodNs = 4'000'000;
  static constexpr double kDamping = 2.0;           // N s/m, while nothing fresh comes
  static constexpr double kMostDampingShare = 0.2;  // of the limit

  struct Options {
    DeviceLimits limits;                      // peak, as claimed; held to what a hand may get
    DeviceLimits continuous;                  // for ever, as claimed
    double damping = kDamping;                // N s/m that the device bears
    bool passivity_control = false;           // pays an active port's debt back by damping
    std::int64_t period_ns = kLeastPeriodNs;  // of the ticks
  };

  explicit MotorGuard(const Options& options) noexcept;

  /// What the motor may be given; once a tick, right before it is.
  Wrench Pass(const MotorInput& input, const MotorOrder& order) noexcept;

  /// When an order that answers an input of `input_ns` is too old: waiting for a fresh one ends
  /// then.
  static constexpr std::int64_t ExpiryOf(std::int64_t input_ns) noexcept {
    return input_ns < 0 ? 0 : input_ns + kDampingNs;
  }

  SafetyState state() const noexcept { return state_; }
  const SafetyCounts& counts() const noexcept { return counts_; }
  const DeviceLimits& limits() const noexcept { return limits_; }
  /// The most that force (N) and moment (N m) change by in a tick.
  DeviceLimits slew() const noexcept {
    const double ms = 1e-6 * static_cast<double>(options_.period_ns);
    return {limits_.force * ms / kSlewTicks, limits_.moment * ms / kSlewTicks};
  }
  const PassivityObserver& passivity() const noexcept { return passivity_; }
  /// Ticks in which the passivity control damped.
  std::uint64_t damped() const noexcept { return damped_; }
  bool passivity_control() const noexcept { return options_.passivity_control; }

 private:
  /// The state of this tick; counts what ends a force.
  void Judge(const MotorInput& input, const MotorOrder& order) noexcept;
  /// Whether the handle is too fast, or has been and is not slow again, whatever the state.
  bool TooFast(const MotorInput& input) noexcept;
  /// Enters a state without force, unless a graver one holds; counts it.
  void Latch(SafetyState state) noexcept;
  /// Begins the ramp of a second.
  void Ramp(std::int64_t now_ns) noexcept;
  /// The smaller of the shares of both ramps.
  double RampShare(std::int64_t now_ns) const noexcept;
  /// What the state lets be asked of the motor.
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
  // of the ramp of a second, without what orders were late meanwhile; of the short one after that
  std::int64_t ramp_begin_ns_ = 0;
  std::int64_t short_begin_ns_ = 0;
  std::int64_t ramped_ns_ = 0;  // how far the former had come when orders were late
  std::uint64_t damped_ = 0;
  std::uint32_t ramps_ = 0;  // as last seen
  std::uint32_t stops_ = 0;
  std::uint32_t resumes_ = 0;
  bool late_ = false;  // in the last tick
  bool pressed_ = false;
  bool hard_ = false;  // what is given falls at once
  // where the handle was in the last ticks: a driver's own speed may be wrong
  struct Place {
    std::int64_t ns = -1;
    Vec3 p_WD = Vec3::Zero();
  };
  std::array<Place, 16> places_{};
  std::size_t place_ = 0;
};

}  // namespace tandem
