#pragma once

#include <cstdint>

#include "engine/haptics/device_memory.h"

namespace tandem {

/// The controller's end of a device that a process of its own has in hand. Read() gives the newest
/// tick, for which it waits a bounded while where the device's tick is due at the same time as
/// ours; Render() publishes the order that answers it. Nothing here depends on the other process: a
/// device that is silent leaves the handle where it was, at rest.
///
/// After a force was taken away by lateness, overrun or sleep, it asks for a ramp-in as soon as it
/// has been in time for a while. After a fault a person has to: Resume().
class ProcessDevice : public Device {
 public:
  static constexpr std::int64_t kWaitNs = 200'000;  // for a tick that is due now
  static constexpr std::int64_t kSpinNs = 60'000;   // of that, without sleeping
  static constexpr std::int64_t kFrameNs = 1'000'000;
  static constexpr int kSilent = 5;                 // ticks that did not come: nobody waits then
  static constexpr int kCalmFrames = 100;           // in time, before a ramp-in is asked for

  /// `memory`: ready, and outlives the device.
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
  /// Frames since the device last said something.
  int silent_frames() const noexcept { return silent_; }

 private:
  DeviceMemory* memory_;
  DeviceCapabilities capabilities_;
  DeviceTick tick_;
  DeviceOrder order_;
  Anchor handle_;
  int every_;  // frames from a tick of the device to its next
  int since_ = 0;  // the last tick, frames
  int silent_ = kSilent;
  int calm_ = 0;
};

}  // namespace tandem
