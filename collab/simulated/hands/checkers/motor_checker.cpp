#include "collab/simulated/hands/checkers/motor_checker.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr double kRounding = 1e-9;
constexpr double kSlewTicks = 6;           // ticks from the limit to no force
constexpr std::int64_t kLate = 5'000'000;  // ns
constexpr std::int64_t kSilent = 20'000'000;
constexpr double kLateDamping = 2;     // N s/m
constexpr double kDampingShare = 0.2;  // share of the limit
constexpr double kRamp = 1;            // s
constexpr double kShortRamp = 0.1;     // s
constexpr double kFast = 1;            // m/s
constexpr double kFastTurn = 20;       // rad/s

}  // namespace

void MotorChecker::Break(const char* sort, const Wrench& given) {
  violations_->Add(sort, id_, Text("%.3f N, %.4f N m", given.f.norm(), given.tau.norm()));
}

bool MotorChecker::Exceeds(const Wrench& given, double share) const {
  const double most = std::max(0.0, share);
  return given.f.norm() > most * limits_.force + kRounding ||
         given.tau.norm() > most * limits_.moment + kRounding;
}

void MotorChecker::Note(const MotorTick& tick, bool now, Ended& ended) {
  if (now && !ended.now) {
    ended.ticks = 0;
    ended.ramps = tick.ramps + tick.resumes;
  }
  if (now) ended.last_ns = tick.now_ns;
  ended.now = now;
  ++ended.ticks;
}

void MotorChecker::Check(const MotorTick& tick) {
  if (!tick.given.f.allFinite() || !tick.given.tau.allFinite()) {
    return violations_->Add("what a motor gets is not finite", id_);
  }
  const std::int64_t gap_ns = before_ ? tick.now_ns - before_->now_ns : 0;
  const std::int64_t age_ns = tick.input_ns < 0 ? kSilent : tick.now_ns - tick.input_ns;
  const bool silent = age_ns >= kSilent || gap_ns > kSilent || tick.slept;
  const bool stop_begins = tick.ending || (tick.button && !(before_ && before_->button)) ||
                           (before_ && tick.stops != before_->stops);
  const bool resumed = before_ && tick.resumes != before_->resumes && !tick.button && !stop_begins;
  const bool was_fast = fast_.now;
  const double share = was_fast ? 0.5 : 1;
  // an invalid handle has no speed
  const bool fast = tick.sound && (tick.V_WD.v.norm() > share * kFast * (1 + kRounding) ||
                                   tick.V_WD.w.norm() > share * kFastTurn * (1 + kRounding));
  Note(tick, stop_begins || (stopped_.now && !resumed), stopped_);
  Note(tick, !tick.sound, faulty_);
  Note(tick, silent, silent_);
  Note(tick, fast || (was_fast && !tick.sound), fast_);
  Note(tick, age_ns >= kLate && age_ns < kSilent, late_);
  begun_ = begun_ || tick.ramps > 0;

  CheckSize(tick, silent);
  if (!begun_ && Exceeds(tick.given, 0))
    Break("a motor has force before anybody began", tick.given);
  if (silent && Exceeds(tick.given, 0))
    Break("a motor has force that nobody stands for", tick.given);
  if (late_.now) CheckDamping(tick, age_ns);
  CheckEnded(tick, stopped_, true, "a motor has force during a stop");
  CheckEnded(tick, faulty_, true, "a motor has force in spite of a fault");
  CheckEnded(tick, fast_, false, "a motor has force though the handle is too fast");
  if (!silent_.now && silent_.last_ns >= 0 && tick.ramps + tick.resumes == silent_.ramps &&
      Exceeds(tick.given, 0)) {
    Break("a motor's force comes back by itself", tick.given);
  }
  for (const Ended* ended : {&stopped_, &faulty_, &silent_, &fast_}) {
    CheckRamp(tick, *ended, kRamp, 0);
  }
  CheckRamp(tick, late_, kShortRamp, kDampingShare);
  before_ = tick;
}

void MotorChecker::CheckSize(const MotorTick& tick, bool may_drop) {
  if (Exceeds(tick.given, 1)) Break("a motor's force is beyond the clamp", tick.given);
  const Wrench last = before_ ? before_->given : Wrench{};
  const Wrench step{tick.given.tau - last.tau, tick.given.f - last.f};
  if (may_drop && !Exceeds(tick.given, 0)) return;
  if (Exceeds(step, 1 / kSlewTicks)) Break("a motor's force jumps", step);
}

void MotorChecker::CheckDamping(const MotorTick& tick, std::int64_t age_ns) {
  // damping ends at 12 ms: a little before and after, both damping and no damping are right
  Vec3 damping = -kLateDamping * tick.V_WD.v;
  const double most = kDampingShare * limits_.force;
  if (damping.norm() > most) damping *= most / damping.norm();
  const bool fades = age_ns > 11'000'000;
  const double fallen = (late_.ticks - (fades ? 2 : 0)) / kSlewTicks;
  const double left = std::max(0.0, 1 + kDampingShare - fallen) * limits_.force;
  // no damping is right as well, and so is all between
  const double size = damping.squaredNorm();
  const double part = size > 0 ? std::clamp(tick.given.f.dot(damping) / size, 0.0, 1.0) : 0.0;
  const double beside = (tick.given.f - part * damping).norm();
  const double turned = (damping - damping_).norm();
  damping_ = damping;
  // one tick behind the motion
  const bool is_damping = beside <= left + (late_.ticks > 1 ? turned : most) + kRounding;
  const double left_moment = std::max(0.0, 1 - late_.ticks / kSlewTicks) * limits_.moment;
  if (!is_damping || tick.given.tau.norm() > left_moment + kRounding) {
    Break("a motor has more than damping of a late order", tick.given);
  }
}

void MotorChecker::CheckEnded(const MotorTick& tick, const Ended& ended, bool for_good,
                              const char* sort) {
  if (ended.now && Exceeds(tick.given, 1 - ended.ticks / kSlewTicks)) Break(sort, tick.given);
  // it is over, and no ramp-in was asked for
  if (ended.now || !for_good || ended.last_ns < 0) return;
  const bool requested = tick.ramps + tick.resumes != ended.ramps;
  const double share = 1 - ended.ticks / kSlewTicks;
  if (!requested && Exceeds(tick.given, share)) Break(sort, tick.given);
}

void MotorChecker::CheckRamp(const MotorTick& tick, const Ended& ended, double ramp_s,
                             double floor) {
  if (ended.now || ended.last_ns < 0) return;
  const double since_s = ToSeconds(tick.now_ns - ended.last_ns);
  // the former force still falls towards the ramp
  const double falling = std::max(0.0, 1 - ended.ticks / kSlewTicks);
  const double share = falling + floor + since_s / ramp_s;
  if (share < 1 && Exceeds(tick.given, share)) {
    violations_->Add(
        "a motor's force comes back faster than its ramp", id_,
        Text("%.3f N, %d ticks after ", tick.given.f.norm(), ended.ticks) + CauseOf(ended));
  }
}

std::string MotorChecker::CauseOf(const Ended& ended) const {
  if (&ended == &stopped_) return "stop";
  if (&ended == &faulty_) return "fault";
  if (&ended == &silent_) return "silence";
  return &ended == &fast_ ? "speed" : "lateness";
}

}  // namespace tandem
