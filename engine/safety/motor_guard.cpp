#include "engine/safety/motor_guard.h"

#include <algorithm>

#include "engine/base/units.h"
#include "engine/safety/clamp_length.h"

namespace tandem {
namespace {

/// Returns the gravity of a state: of two causes the graver one holds, because its end requires
/// more.
int RankOf(SafetyState state) {
  switch (state) {
    case SafetyState::kStopped:
      return 4;
    case SafetyState::kFault:
      return 3;
    case SafetyState::kExpired:
    case SafetyState::kOverrun:
    case SafetyState::kSuspended:
      return 2;
    case SafetyState::kOff:
      return 1;
    default:
      return 0;
  }
}

bool IsLatched(SafetyState state) {
  return RankOf(state) > 0;
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
      limits_(ValidLimits(options.limits)),
      mean_force_(ValidLimits(options.continuous).force, limits_.force),
      mean_moment_(ValidLimits(options.continuous).moment, limits_.moment) {
  options_.damping = ValidLimit(options.damping, kDamping);
  options_.period_ns = std::clamp(options.period_ns, kLeastPeriodNs, kMostPeriodNs);
}

void MotorGuard::Latch(SafetyState state) noexcept {
  if (state_ == state) return;
  if (IsLatched(state_) && RankOf(state) <= RankOf(state_)) return;
  if (state == SafetyState::kStopped) ++counts_.stops;
  // a state without force cannot lose it; orders that are too old are counted where they begin
  if (!IsLatched(state_) && state != SafetyState::kStopped && state != SafetyState::kExpired) {
    ++counts_.zeroed;
  }
  state_ = state;
}

void MotorGuard::Ramp(std::int64_t now_ns) noexcept {
  state_ = SafetyState::kRamping;
  ramp_begin_ns_ = now_ns;
  short_begin_ns_ = now_ns - kShortRampNs;
}

double MotorGuard::RampShare(std::int64_t now_ns) const noexcept {
  const auto share = [now_ns](std::int64_t begin_ns, std::int64_t length_ns) {
    return std::clamp(static_cast<double>(now_ns - begin_ns) / static_cast<double>(length_ns), 0.0,
                      1.0);
  };
  return std::min(share(ramp_begin_ns_, kRampNs), share(short_begin_ns_, kShortRampNs));
}

bool MotorGuard::TooFast(const MotorInput& input) noexcept {
  const double share = fast_ ? kSlowAgain : 1.0;
  double speed = input.V_WD.v.norm();
  const Place& before = places_[place_];  // the oldest
  if (before.ns >= 0 && input.now_ns > before.ns) {
    const double h = ToSeconds(input.now_ns - before.ns);
    speed = std::max(speed, (input.p_WD - before.p_WD).norm() / h);
  }
  places_[place_] = {input.now_ns, input.p_WD};
  place_ = (place_ + 1) % places_.size();
  fast_ = speed > share * kMostSpeed || input.V_WD.w.norm() > share * kMostTurn;
  return fast_;
}

void MotorGuard::Judge(const MotorInput& input, const MotorOrder& order) noexcept {
  const std::int64_t age_ns = order.input_ns < 0 ? kZeroNs : input.now_ns - order.input_ns;
  const bool sound = Finite(input) && Finite(order) && !input.failed;
  const bool fast = Finite(input) ? TooFast(input) : fast_;
  const bool gap = last_ns_ >= 0 && input.now_ns - last_ns_ > kMostGapNs;
  const bool late = age_ns >= kDampingNs;

  const bool pressed = (input.stop_button && !pressed_) || (order.stops != stops_) || input.ending;
  pressed_ = input.stop_button;
  const bool resumed = order.resumes != resumes_ && !pressed && !input.stop_button;
  const bool ramp_asked = order.ramps != ramps_ || resumed;
  stops_ = order.stops;
  resumes_ = order.resumes;
  if (pressed) {
    Latch(SafetyState::kStopped);
  } else if (resumed &&
             (state_ == SafetyState::kStopped || (state_ == SafetyState::kFault && sound))) {
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
  if (!sound) Latch(SafetyState::kFault);
  if (input.slept) Latch(SafetyState::kSuspended);
  if (gap) Latch(SafetyState::kOverrun);
  // before the first order no order is late
  const bool silent = state_ == SafetyState::kOff && order.input_ns < 0;
  if (age_ns >= kZeroNs && !silent) Latch(SafetyState::kExpired);
  if (IsLatched(state_)) {
    // a person ends a fault: requests of a program are forgotten meanwhile
    if (state_ == SafetyState::kFault) {
      ramps_ = order.ramps;
      return;
    }
    if (!ramp_asked || late || fast || gap || input.slept) return;
    ramps_ = order.ramps;
    Ramp(input.now_ns);
    return;
  }
  ramps_ = order.ramps;
  if (fast) {
    Latch(SafetyState::kTooFast);
    return;
  }
  if (state_ == SafetyState::kTooFast) {
    if (!late) Ramp(input.now_ns);
    return;
  }
  if (late && state_ != SafetyState::kDamping) {
    state_ = SafetyState::kDamping;
    ramped_ns_ = input.now_ns - ramp_begin_ns_;
  } else if (!late && state_ == SafetyState::kDamping) {
    // a short ramp, and the ramp-in continues from where it had come
    state_ = SafetyState::kRamping;
    ramp_begin_ns_ = input.now_ns - ramped_ns_;
    short_begin_ns_ = input.now_ns;
  } else if (state_ == SafetyState::kRamping && RampShare(input.now_ns) >= 1.0) {
    state_ = SafetyState::kOn;
  }
}

Wrench MotorGuard::Wanted(const MotorInput& input, const MotorOrder& order) const noexcept {
  Wrench desired;
  if (state_ == SafetyState::kDamping) {
    if (input.now_ns - order.input_ns >= kFadeNs) return desired;
    bool cut = false;
    const double ramped = std::min(1.0, static_cast<double>(ramped_ns_) / kRampNs);
    desired.f = ramped * ClampLength(-options_.damping * input.V_WD.v,
                                     kMostDampingShare * limits_.force, cut);
    return desired;
  }
  if (!GivesForce(state_)) return desired;
  const double share = state_ == SafetyState::kRamping ? RampShare(input.now_ns) : 1.0;
  desired.f = share * order.F_D_W.f;
  desired.tau = share * order.F_D_W.tau;
  return desired;
}

Wrench MotorGuard::Pass(const MotorInput& input, const MotorOrder& order) noexcept {
  const std::int64_t since_ns = last_ns_ < 0 ? 0 : input.now_ns - last_ns_;
  const double h = ToSeconds(since_ns);
  mean_force_.RecordForce(last_.f.norm(), since_ns);
  mean_moment_.RecordForce(last_.tau.norm(), since_ns);
  if (Finite(input)) passivity_.Observe(last_, input.V_WD, h);
  Judge(input, order);
  last_ns_ = input.now_ns;

  Wrench desired = Wanted(input, order);
  if (options_.passivity_control && GivesForce(state_) && h > 0) {
    const Vec3 payment = passivity_.DampingForce(input.V_WD, h, options_.damping);
    damped_ += payment.isZero() ? 0 : 1;
    desired.f += payment;
  }
  bool clamped = false;
  bool slewed = false;
  const double most_force = std::min(limits_.force, mean_force_.Allowed());
  const double most_moment = std::min(limits_.moment, mean_moment_.Allowed());
  desired.f = ClampLength(desired.f, most_force, clamped);
  desired.tau = ClampLength(desired.tau, most_moment, clamped);
  if (hard_) {
    last_ = {};
    return last_;
  }
  last_.f = StepTowards(last_.f, desired.f, slew().force, slewed);
  last_.tau = StepTowards(last_.tau, desired.tau, slew().moment, slewed);
  counts_.clamped += clamped ? 1 : 0;
  counts_.slewed += slewed ? 1 : 0;
  return last_;
}

}  // namespace tandem
