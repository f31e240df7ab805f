#include "engine/haptics/scripted_device.h"

#include <utility>

#include "engine/world/world.h"

namespace tandem {

ScriptedDevice::ScriptedDevice(HandScript script, const Pose& X_WB0)
    : script_(std::move(script)), X_WB0_(X_WB0) {
  if (script_.waypoints.empty()) script_.waypoints.emplace_back();
  state_.X_WB = X_WB0_ * script_.X_BD;
}

Anchor ScriptedDevice::Intent() const noexcept {
  const Waypoint way = script_.IntentAt(time_);
  const Twist V = script_.IntendedTwistAt(time_);
  const Pose X_WB{way.q_W * X_WB0_.q, X_WB0_.p + way.p_W};
  const Vec3 r = X_WB.q * script_.X_BD.p;
  return {X_WB * script_.X_BD, {V.w, V.v + V.w.cross(r)}};
}

void ScriptedDevice::Render(const Wrench& F_D_W) noexcept {
  const HandImpedance& hand = script_.impedance;
  const CouplingGains gains{hand.stiffness, hand.damping,
                            hand.rotation_stiffness * Mat3::Identity(),
                            hand.rotation_damping * Mat3::Identity()};
  if (started_) time_ += kFrame;
  Load load = CouplingLoad(gains, state_, Pose{}, Intent());
  load.force.head<3>() += F_D_W.tau;
  load.force.tail<3>() += F_D_W.f;
  const Inertia inertia{hand.mass, hand.inertia * Mat3::Identity()};
  const Twist V = ImplicitTwist(inertia, state_, load, kFrame);
  Advance(state_, V, kFrame, 0.0, 1e9);
}

}  // namespace tandem
