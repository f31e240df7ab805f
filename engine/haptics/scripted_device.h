#pragma once

#include "engine/dynamics/rigid_body.h"
#include "engine/haptics/device.h"
#include "engine/haptics/hand_script.h"
#include "engine/world/world.h"

namespace tandem {

/// Returns the script's target of the handle at time t (s, from 0), for a body that first stands at
/// X_WB0.
Anchor IntendedHandle(const HandScript& script, const Pose& X_WB0, double t) noexcept;

/// A hand that follows a script through its impedance, so that sessions run without hardware and
/// the hand gives way as a real one does. Its clock counts frames from Start().
class ScriptedDevice : public Device {
 public:
  /// `X_WB0`: first pose of the body that it will hold. A script without waypoints holds it there.
  ScriptedDevice(HandScript script, const Pose& X_WB0);

  void Start() noexcept override { started_ = true; }
  Anchor Read() noexcept override { return {state_.X_WB, state_.V_WB}; }
  void Render(const Wrench& F_D_W) noexcept override;

  double time() const noexcept { return time_; }  // s since Start()
  const HandScript& script() const noexcept { return script_; }

 private:
  HandScript script_;
  Pose X_WB0_;
  RigidState state_;  // state of the handle
  double time_ = 0;
  bool started_ = false;
};

}  // namespace tandem
