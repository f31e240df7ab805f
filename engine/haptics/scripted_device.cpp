#include "engine/haptics/scripted_device.h"

#include <utility>

namespace tandem {

ScriptedDevice::ScriptedDevice(HandScript script, const Pose& X_WB0)
    : script_(std::move(script)), X_WB0_(X_WB0) {
  if (script_.waypoints.empty()) script_.waypoints.emplace_back();
  state_.X_WB = X_WB0_ * script_.X_BD;
}

Anchor IntendedHandle(const HandScript& script, const Pose& X_WB0, double t) noexcept {
  const Waypoint way = script.IntentAt(t);
  const Twist V = script.IntendedTwistAt(t);
  const Pose X_WB{way.q_W * X_WB0.q, X_WB0.p + way.p_W};
  const Vec3 r = X_WB.q * script.X_BD.p;
  return {X_WB * script.X_BD, {V.w, V.v + V.w.cross(r)}};
}

void ScriptedDevice::Render(const Wrench& F_D_W) noexcept {
  const HandImpedance& hand = script_.impedance;
  const CouplingGains gains{hand.stiffness, hand.damping,
                            hand.rotation_stiffness * Mat3::Identity(),
                            hand.rotation_damping * Mat3::Identity()};
  const Wrench push_D_W = started_ ? script_.PushAt(time_) : Wrench{};
  if (started_) time_ += kFrame;
  LinearizedForce load =
      CouplingForce(gains, state_, Pose{}, IntendedHandle(script_, X_WB0_, time_));
  load.force.head<3>() += F_D_W.tau + push_D_W.tau;
  load.force.tail<3>() += F_D_W.f + push_D_W.f;
  const Inertia inertia{hand.mass, hand.inertia * Mat3::Identity()};
  const Twist V = ImplicitTwist(inertia, state_, load, kFrame);
  Advance(state_, V, kFrame, 0.0, 1e9);
}

}  // namespace tandem
