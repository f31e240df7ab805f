#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/safety/clamp_length.h"
#include "engine/safety/device_limits.h"
#include "engine/safety/safety_state.h"

namespace tandem {

/// The simulation's guard between itself and a hand. Whatever the simulation asks for, the guard
/// asks the device for a finite wrench within its limits. The wrench changes by at most the slew
/// from one frame to the next and rises from nothing after each Begin() (paper §6;
/// docs/decisions/0021-force-guard.md). The guard limits force and moment separately, in size, so
/// that their directions stay. A wrench that is not finite counts as zero, and so do all that
/// follow until the next Begin(), because a simulation that has diverged does not recover. A device
/// with its own process has a MotorGuard besides. Used by the haptic thread alone.
class ForceGuard {
 public:
  // for a device of 12 N and 0.5 N m: six frames from nothing to the limit; for others in
  // proportion
  static constexpr double kForceStep = 2.0;     // N a frame
  static constexpr double kMomentStep = 0.08;   // N m a frame
  static constexpr int kRampFrames = 100;       // ramp from nothing to the whole, at a grab
  static constexpr int kLongRampFrames = 1000;  // the same after a stop or a fault

  static constexpr double ForceStepOf(const DeviceLimits& limits) noexcept {
    return kForceStep * (limits.force / DeviceLimits{}.force);
  }
  static constexpr double MomentStepOf(const DeviceLimits& limits) noexcept {
    return kMomentStep * (limits.moment / DeviceLimits{}.moment);
  }

  explicit ForceGuard(const DeviceLimits& limits) : limits_(ValidLimits(limits)) {}

  /// Begins a ramp-in: at the start, and whenever a hand takes a body. It ends a fault of the
  /// simulation; only Resume() ends a device's fault.
  void Begin() noexcept {
    ramp_ = 0;
    if (broken_) long_ramp_ = 0;
    broken_ = false;
  }

  /// Emergency stop: no force, whatever begins, until Resume().
  void Stop() noexcept {
    if (!stopped_) ++counts_.stops;
    stopped_ = true;
  }
  /// Fault of the device: no force until Resume().
  void Fail() noexcept {
    if (!failed_) ++counts_.zeroed;
    failed_ = true;
  }
  /// Ends a stop and a fault; the force comes back slowly.
  void Resume() noexcept {
    if (!stopped_ && !broken_ && !failed_) return;
    stopped_ = broken_ = failed_ = false;
    ramp_ = long_ramp_ = 0;
  }

  /// Returns the wrench that the device may get in place of `desired`; called once a frame.
  Wrench Pass(const Wrench& desired) noexcept {
    ++frames_;
    if (!broken_ && (!desired.f.allFinite() || !desired.tau.allFinite())) {
      broken_ = true;
      ++counts_.zeroed;
    }
    const bool nothing = broken_ || failed_ || stopped_;
    ramp_ = std::min(ramp_ + 1, kRampFrames);
    long_ramp_ = std::min(long_ramp_ + 1, kLongRampFrames);
    const double share = std::min(static_cast<double>(ramp_) / kRampFrames,
                                  static_cast<double>(long_ramp_) / kLongRampFrames);
    Wrench goal;
    if (!nothing) goal = {share * desired.tau, share * desired.f};
    bool clamped = false;
    bool slewed = false;
    last_.f = StepTowards(last_.f, ClampLength(goal.f, limits_.force, clamped),
                          ForceStepOf(limits_), slewed);
    last_.tau = StepTowards(last_.tau, ClampLength(goal.tau, limits_.moment, clamped),
                            MomentStepOf(limits_), slewed);
    counts_.clamped += clamped ? 1 : 0;
    counts_.slewed += slewed ? 1 : 0;
    guarded_ += nothing || clamped || slewed ? 1 : 0;
    return last_;
  }

  /// Tells whether a wrench that was not finite was asked for since Begin().
  bool broken() const noexcept { return broken_; }
  /// Tells whether an emergency stop holds.
  bool stopped() const noexcept { return stopped_; }
  SafetyState state() const noexcept {
    if (stopped_) return SafetyState::kStopped;
    if (broken_ || failed_) return SafetyState::kFault;
    const bool ramping = ramp_ < kRampFrames || long_ramp_ < kLongRampFrames;
    return ramping ? SafetyState::kRamping : SafetyState::kOn;
  }
  const SafetyCounts& counts() const noexcept { return counts_; }
  const DeviceLimits& limits() const noexcept { return limits_; }
  /// Number of frames in which the device got another wrench than the simulation wanted, apart from
  /// the ramp; and of all frames.
  std::uint64_t guarded() const noexcept { return guarded_; }
  std::uint64_t frames() const noexcept { return frames_; }
  double guarded_share() const noexcept {
    return frames_ == 0 ? 0.0 : static_cast<double>(guarded_) / static_cast<double>(frames_);
  }

 private:
  DeviceLimits limits_;
  Wrench last_;
  int ramp_ = 0;
  int long_ramp_ = kLongRampFrames;
  bool broken_ = false;
  bool failed_ = false;  // fault of the device
  bool stopped_ = false;
  std::uint64_t guarded_ = 0;
  std::uint64_t frames_ = 0;
  SafetyCounts counts_;
};

}  // namespace tandem
