#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/safety/device_limits.h"
#include "engine/safety/held_within.h"
#include "engine/safety/safety_state.h"

namespace tandem {

/// The simulation's end of what stands between it and a hand: whatever the simulation asks for, the
/// device is asked for a finite wrench within its limits, which changes by at most the slew from
/// one frame to the next and rises from nothing after each Begin() (paper §6;
/// docs/decisions/0021-force-guard.md). Force and moment are guarded each by itself, in size, so
/// that their directions stay. What is not finite counts as zero, and all that follows too until
/// the next Begin(): a simulation that has once left the numbers does not come back. A device with
/// a process of its own has a MotorGuard besides. Used by the haptic thread alone.
class ForceGuard {
 public:
  // of a device that gives 12 N and 0.5 N m: six frames from nothing to the limit; others alike
  static constexpr double kForceStep = 2.0;    // N a frame
  static constexpr double kMomentStep = 0.08;  // N m a frame
  static constexpr int kRampFrames = 100;      // from nothing to the whole, at a grab
  static constexpr int kLongRampFrames = 1000;  // likewise, after a stop or a fault

  static constexpr double ForceStepOf(const DeviceLimits& limits) noexcept {
    return kForceStep * (limits.force / DeviceLimits{}.force);
  }
  static constexpr double MomentStepOf(const DeviceLimits& limits) noexcept {
    return kMomentStep * (limits.moment / DeviceLimits{}.moment);
  }

  explicit ForceGuard(const DeviceLimits& limits) : limits_(SoundLimits(limits)) {}

  /// A hand begins to feel something: at the start, and whenever it takes a body. What a simulation
  /// broke ends by that; a device's fault ends by Resume() alone.
  void Begin() noexcept {
    ramp_ = 0;
    if (broken_) long_ramp_ = 0;
    broken_ = false;
  }

  /// Emergency stop: no force from now on, whatever begins, until Resume().
  void Stop() noexcept {
    if (!stopped_) ++counts_.stops;
    stopped_ = true;
  }
  /// A device in trouble: no force from now on, until Resume().
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

  /// What the device may be given in place of `wanted`; once a frame.
  Wrench Pass(const Wrench& wanted) noexcept {
    ++frames_;
    if (!broken_ && (!wanted.f.allFinite() || !wanted.tau.allFinite())) {
      broken_ = true;
      ++counts_.zeroed;
    }
    const bool nothing = broken_ || failed_ || stopped_;
    ramp_ = std::min(ramp_ + 1, kRampFrames);
    long_ramp_ = std::min(long_ramp_ + 1, kLongRampFrames);
    const double share = std::min(static_cast<double>(ramp_) / kRampFrames,
                                  static_cast<double>(long_ramp_) / kLongRampFrames);
    Wrench goal;
    if (!nothing) goal = {share * wanted.tau, share * wanted.f};
    bool clamped = false;
    bool slewed = false;
    last_.f = SteppedTo(last_.f, HeldWithin(goal.f, limits_.force, clamped), ForceStepOf(limits_),
                        slewed);
    last_.tau = SteppedTo(last_.tau, HeldWithin(goal.tau, limits_.moment, clamped),
                          MomentStepOf(limits_), slewed);
    counts_.clamped += clamped ? 1 : 0;
    counts_.slewed += slewed ? 1 : 0;
    guarded_ += nothing || clamped || slewed ? 1 : 0;
    return last_;
  }

  /// Whether something that was not finite was asked for since Begin().
  bool broken() const noexcept { return broken_; }
  /// Whether an emergency stop holds.
  bool stopped() const noexcept { return stopped_; }
  SafetyState state() const noexcept {
    if (stopped_) return SafetyState::kStopped;
    if (broken_ || failed_) return SafetyState::kFault;
    const bool ramping = ramp_ < kRampFrames || long_ramp_ < kLongRampFrames;
    return ramping ? SafetyState::kRamping : SafetyState::kOn;
  }
  const SafetyCounts& counts() const noexcept { return counts_; }
  const DeviceLimits& limits() const noexcept { return limits_; }
  /// Frames in which the device got something else than was wanted, the ramp apart; and all.
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
  bool failed_ = false;  // the device
  bool stopped_ = false;
  std::uint64_t guarded_ = 0;
  std::uint64_t frames_ = 0;
  SafetyCounts counts_;
};

}  // namespace tandem
