#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/haptics/device.h"

namespace tandem {

/// The last thing before a device: whatever the simulation asks for, the hand gets a finite wrench
/// within the device's limits, which changes by at most the slew from one frame to the next and
/// rises from nothing after each Begin() (paper §6; docs/decisions/0021-force-guard.md). Force
/// and moment are guarded each by itself, in size, so that their directions stay. What is not
/// finite counts as zero, and all that follows too until the next Begin(): a simulation that has
/// once left the numbers does not come back. Used by the haptic thread alone.
class ForceGuard {
 public:
  static constexpr double kForceStep = 2.0;    // N a frame
  static constexpr double kMomentStep = 0.08;  // N m a frame: as long from nothing to the limit
  static constexpr int kRampFrames = 100;      // from nothing to the whole

  explicit ForceGuard(const DeviceLimits& limits) : limits_(limits) {}

  /// A hand begins to feel something: at the start, and whenever it takes a body.
  void Begin() noexcept {
    ramp_ = 0;
    stopped_ = false;
  }

  /// What the device may be given in place of `wanted`; once a frame.
  Wrench Pass(const Wrench& wanted) noexcept {
    ++frames_;
    stopped_ = stopped_ || !wanted.f.allFinite() || !wanted.tau.allFinite();
    ramp_ = std::min(ramp_ + 1, kRampFrames);
    const double share = static_cast<double>(ramp_) / kRampFrames;
    Wrench goal;
    if (!stopped_) goal = {share * wanted.tau, share * wanted.f};
    bool held_back = stopped_;
    last_.f = Step(last_.f, Within(goal.f, limits_.force, held_back), kForceStep, held_back);
    last_.tau =
        Step(last_.tau, Within(goal.tau, limits_.moment, held_back), kMomentStep, held_back);
    guarded_ += held_back ? 1 : 0;
    return last_;
  }

  /// Whether something that was not finite was asked for since Begin().
  bool stopped() const noexcept { return stopped_; }
  /// Frames in which the device got something else than was wanted, the ramp apart; and all.
  std::uint64_t guarded() const noexcept { return guarded_; }
  std::uint64_t frames() const noexcept { return frames_; }
  double guarded_share() const noexcept {
    return frames_ == 0 ? 0.0 : static_cast<double>(guarded_) / static_cast<double>(frames_);
  }

 private:
  // stableNorm: what is finite stays finite
  static Vec3 Within(const Vec3& v, double most, bool& held_back) noexcept {
    const double size = v.stableNorm();
    if (size <= most) return v;
    held_back = true;
    return (most * v.cwiseQuotient(Vec3::Constant(size)));
  }
  static Vec3 Step(const Vec3& from, const Vec3& to, double most, bool& held_back) noexcept {
    return from + Within(to - from, most, held_back);
  }

  DeviceLimits limits_;
  Wrench last_;
  int ramp_ = 0;
  bool stopped_ = false;
  std::uint64_t guarded_ = 0;
  std::uint64_t frames_ = 0;
};

}  // namespace tandem
