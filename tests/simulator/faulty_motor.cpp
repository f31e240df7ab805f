#include "tests/simulator/faulty_motor.h"

#include <limits>

#include "tests/simulator/injected_hand_faults.h"

namespace tandem {

Wrench FaultyMotor::Give(const MotorTick& tick, SafetyState state) {
  ++ticks_;
  const Wrench& F_D_W = tick.given;
  const std::int64_t age_ns = tick.now_ns - tick.input_ns;
  const bool fresh = tick.input_ns >= 0 && age_ns < MotorGuard::kDampingNs;
  if (fresh) kept_ = {F_D_W.tau, F_D_W.f + Vec3(0, 0, 0.3)};
  const bool too_fast = tick.V_WD.v.norm() > MotorGuard::kMostSpeed;
  if (Injected(HandFault::kMotorTenfold)) return {10 * F_D_W.tau, 10 * F_D_W.f};
  if (Injected(HandFault::kMotorJumps)) {
    return ticks_ % 2 == 0 ? F_D_W : Wrench{-F_D_W.tau, -F_D_W.f};
  }
  if (Injected(HandFault::kMotorNoNumber) && ticks_ > 500) {
    return {F_D_W.tau, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())};
  }
  if (Injected(HandFault::kMotorKeeps) && !fresh) return kept_;
  if (Injected(HandFault::kMotorPushesOn) && !fresh) {
    return {F_D_W.tau, -F_D_W.f + 0.2 * tick.V_WD.v};
  }
  if (Injected(HandFault::kMotorAfterStop) && state == SafetyState::kStopped) return kept_;
  if (Injected(HandFault::kMotorAfterFault) && state == SafetyState::kFault) return kept_;
  if (Injected(HandFault::kMotorAtOnce)) {
    if (tick.ramps == 0) return {Vec3(0, 0, 0), Vec3(0, 0, 0.3)};
    if (!fresh) kept_ = {};
    if (fresh && state != SafetyState::kOn) return kept_;
  }
  if (Injected(HandFault::kMotorTooFast) && too_fast) return kept_;
  return F_D_W;
}

}  // namespace tandem
