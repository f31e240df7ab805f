#pragma once

#include "engine/haptics/scripted_device.h"

namespace tandem {

/// A user's input without force feedback, as of a SpaceMouse or a mouse (paper §6, §6.2): the
/// handle is exactly where the script wants it, whatever pushes back. Such a user is otherwise like
/// any: holds bodies, is felt by others, and its parts stay out of others. Its clock counts frames
/// from Start().
class PassiveDevice : public Device {
 public:
  /// `X_WB0`: first pose of the body it will hold. A script without waypoints stays there.
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
