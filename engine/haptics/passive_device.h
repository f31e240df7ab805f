#pragma once

#include "engine/haptics/scripted_device.h"

namespace tandem {

/// A user's input without force feedback, as from a SpaceMouse or a mouse (paper §6, §6.2). The
/// handle is exactly at the script's target, whatever pushes back. Otherwise the user is like any
/// other: holds bodies, is felt by others, and its parts stay out of others. Its clock counts
/// frames from Start().
class PassiveDevice : public Device {
 public:
  /// `X_WB0`: first pose of the body that it will hold. A script without waypoints stays there.
  PassiveDevice(HandScript script, const Pose& X_WB0);

  void Start() noexcept override { started_ = true; }
  Anchor Read() noexcept override { return IntendedHandle(script_, X_WB0_, time_); }
  void Render(const Wrench&) noexcept override {
    if (started_) time_ += kFrame;
  }

 private:
  HandScript script_;
  Pose X_WB0_;
  double time_ = 0;  // s since Start()
  bool started_ = false;
};

}  // namespace tandem
