#include "engine/safety/motor_guard.h"

#include <algorithm>

#include "engine/safety/held_within.h"

namespace tandem {
namespace {

bool IsLatched(SafetyState state) {
  switch (state) {
    case SafetyState::kOff:
    case SafetyState::kExpired:
    case SafetyState::kOverrun:
    case SafetyState::kFault:
    case SafetyState::kSuspended:
      return true;
    default:
      return false;
  }
}

bool GivesForce(SafetyState state) {
  return state == SafetyState::kRamping || state == SafetyState::kOn ||
         state == SafetyState::kDamping;
}

bool Finite(const MotorInput& input) {
  return input.p_WD.allFinite() && input.V_WD.v.allFinite() && input.V_WD.w.allFinite();
}

bool Finite(const MotorOrder& order) {
  return order.F_D_W.f.allFinite() && order.F_D_W.tau.allFinite();
}

}  // namespace

MotorGuard::MotorGuard(const Options& options) noexcept
    : options_(options),
      limits_(SoundLimits(options.limits)),
      mean_force_(SoundLimits(options.continuous).force, limits_.force),
      mean_moment_(SoundLimits(options.continuous).moment, limits_.moment) {
  options_.damping = SoundLimit(options.damping, kDamping);
}

void MotorGuard::Latch(SafetyState state, std::uint64_t& count) noexcept {
  if (state_ == state) return;
  // what is latched already stays as it is: it needs the same to end
  if (IsLatched(state_) && state_ != SafetyState::kOff && state != SafetyState::kStopped) return;
  if (state_ == SafetyState::kOff && state != SafetyState::kStopped) return;
  state_ = state;
  ++count;
}

void MotorGuard::Ramp(std::int64_t length_ns, std::int64_t now_ns) noexcept {
  state_ = SafetyState::kRamping;
  ramp_begin_ns_ = now_ns;
  ramp_ns_ = length_ns;
}

bool MotorGuard::TooFast(const MotorInput& input) noexcept {
  const double share = state_ == SafetyState::kTooFast ? kSlowAgain : 1.0;
  double speed = input.V_WD.v.norm();
  const Place& before = places_[place_];  // the oldest
  if (before.ns >= 0 && input.now_ns > before.ns) {
    const double h = 1e-9 * static_cast<double>(input.now_ns - before.ns);
    speed = std::max(speed, (input.p_WD - before.p_WD).norm() / h);
  }
  places_[place_] = {input.now_ns, input.p_WD};
  place_ = (place_ + 1) % places_.size();
  return speed > share * kMostSpeed || input.V_WD.w.norm() > share * kMostTurn;
}

void MotorGuard::Judge(const MotorInput& input, const MotorOrder& order) noexcept {
  const std::int64_t age_ns = order.input_ns < 0 ? kZeroNs : input.now_ns - order.input_ns;
  const bool sound = Finite(input) && Finite(order) && !input.failed;
  const bool fast = Finite(input) && TooFast(input);
  const bool gap = last_ns_ >= 0 && input.now_ns - last_ns_ > kMostGapNs;
  const bool late = age_ns >= kDampingNs;

  const bool pressed = (input.stop_button && !pressed_) || (order.stops != stops_) || input.ending;
  pressed_ = input.stop_button;
  const bool resumed = order.resumes != resumes_ && !pressed && !input.stop_button;
  const bool ramp_asked = order.ramps != ramps_ || resumed;
  stops_ = order.stops;
  resumes_ = order.resumes;
  if (pressed) {
    Latch(SafetyState::kStopped, counts_.stops);
  } else if (resumed && state_ == SafetyState::kStopped) {
    state_ = SafetyState::kOff;
  }
  // the motor has kept its force for too long to be let down gently
  hard_ = gap || age_ns >= kZeroNs || input.slept;
  if (state_ == SafetyState::kStopped) {
    ramps_ = order.ramps;
    return;
  }

  if (GivesForce(state_) && late && !late_) ++counts_.expired;
  late_ = late;
  if (!sound) Latch(SafetyState::kFault, counts_.zeroed);
  if (input.slept) Latch(SafetyState::kSuspended, counts_.zeroed);
  if (gap) Latch(SafetyState::kOverrun, counts_.zeroed);
  if (age_ns >= kZeroNs && state_ != SafetyState::kExpired) {
    std::uint64_t counted_already = 0;
    Latch(SafetyState::kExpired, counted_already);
  }
  if (IsLatched(state_)) {
    if (!ramp_asked || late || !sound || fast || gap || input.slept) return;
    ramps_ = order.ramps;
    Ramp(kRampNs, input.now_ns);
    return;
  }
  ramps_ = order.ramps;
  if (fast) {
    Latch(SafetyState::kTooFast, counts_.zeroed);
    return;
  }
  if (state_ == SafetyState::kTooFast) {
    if (!late) Ramp(kRampNs, input.now_ns);
    return;
  }
  if (late) {
    state_ = SafetyState::kDamping;
  } else if (state_ == SafetyState::kDamping) {
    Ramp(kShortRampNs, input.now_ns);
  } else if (state_ == SafetyState::kRamping && input.now_ns - ramp_begin_ns_ >= ramp_ns_) {
    state_ = SafetyState::kOn;
  }
}

Wrench MotorGuard::Wanted(const MotorInput& input, const MotorOrder& order) const noexcept {
  Wrench wanted;
  if (state_ == SafetyState::kDamping) {
    if (input.now_ns - order.input_ns >= kFadeNs) return wanted;
    bool cut = false;
    wanted.f = HeldWithin(-options_.damping * input.V_WD.v, kMostDampingShare * limits_.force, cut);
    return wanted;
  }
  if (!GivesForce(state_)) return wanted;
  double share = 1.0;
  if (state_ == SafetyState::kRamping) {
    share = std::clamp(static_cast<double>(input.now_ns - ramp_begin_ns_) /
                           static_cast<double>(ramp_ns_),
                       0.0, 1.0);
  }
  wanted.f = share * order.F_D_W.f;
  wanted.tau = share * order.F_D_W.tau;
  return wanted;
}

Wrench MotorGuard::Pass(const MotorInput& input, const MotorOrder& order) noexcept {
  const std::int64_t since_ns = last_ns_ < 0 ? 0 : input.now_ns - last_ns_;
  const double h = 1e-9 * static_cast<double>(since_ns);
  mean_force_.Gave(last_.f.norm(), since_ns);
  mean_moment_.Gave(last_.tau.norm(), since_ns);
  if (Finite(input)) passivity_.See(last_, input.V_WD, h);
  Judge(input, order);
  last_ns_ = input.now_ns;

  Wrench wanted = Wanted(input, order);
  if (options_.passivity_control && GivesForce(state_) && h > 0) {
    wanted.f += passivity_.Payment(input.V_WD, h, options_.damping);
  }
  bool clamped = false;
  bool slewed = false;
  const double most_force = std::min(limits_.force, mean_force_.Allowed());
  const double most_moment = std::min(limits_.moment, mean_moment_.Allowed());
  wanted.f = HeldWithin(wanted.f, most_force, clamped);
  wanted.tau = HeldWithin(wanted.tau, most_moment, clamped);
  if (hard_) {
    last_ = {};
    return last_;
  }
  last_.f = SteppedTo(last_.f, wanted.f, slew().force, slewed);
  last_.tau = SteppedTo(last_.tau, wanted.tau, slew().moment, slewed);
  counts_.clamped += clamped ? 1 : 0;
  counts_.slewed += slewed ? 1 : 0;
  return last_;
}

}  // namespace tandem
