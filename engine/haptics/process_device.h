#pragma once

#include <cstdint>

#include "engine/haptics/device_memory.h"

namespace tandem {

/// The controller's end of a device that is in another process. Read() returns the newest tick. It
/// waits a bounded time for it if the device's tick is due at the same time as the frame. Render()
/// publishes the order that answers it. Nothing here depends on the other process: a silent device
/// leaves the handle where it was, at rest.
///
/// After lateness, overrun or sleep has taken the force away, it asks for a ramp-in when it has
/// been in time for a while. After a fault a person must do so by Resume().
class ProcessDevice : public Device {
 public:
  static constexpr std::int64_t kWaitNs = 200'000;  // wait for a tick that is due
  static constexpr std::int64_t kSpinNs = 60'000;   // part of the wait without sleeping
  static constexpr std::int64_t kFrameNs = 1'000'000;
  static constexpr int kSilent = 5;                 // missed ticks after which it does not wait
  static constexpr int kCalmFrames = 100;           // frames in time before it asks for a ramp-in

  /// `memory` must be ready and outlive the device.
  explicit ProcessDevice(DeviceMemory& memory) noexcept;

  void Start() noexcept override;
  Anchor Read() noexcept override;
  void Render(const Wrench& F_D_W) noexcept override;
  void Stop() noexcept override;
  void Resume() noexcept override;
  DeviceCapabilities capabilities() const noexcept override { return capabilities_; }
  bool failed() const noexcept override { return tick_.failed; }
  bool clutch_button() const noexcept override { return tick_.clutch_button; }
  DeviceSafety safety() const noexcept override {
    const bool silent = silent_ >= kSilent;
    return {silent ? SafetyState::kSilent : static_cast<SafetyState>(tick_.state), tick_.counts};
  }
  /// Returns the frames since the last report of the device.
  int silent_frames() const noexcept { return silent_; }

 private:
  DeviceMemory* memory_;
  DeviceCapabilities capabilities_;
  DeviceTick tick_;
  DeviceOrder order_;
  Anchor handle_;
  int every_;  // frames from a tick of the device to its next
  int since_ = 0;  // frames since the last tick
  int silent_ = kSilent;
  int calm_ = 0;
};

}  // namespace tandem
