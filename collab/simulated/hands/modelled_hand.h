#pragma once

#include "collab/simulated/hands/seeded_random.h"
#include "engine/haptics/device.h"

namespace tandem {

/// A person's hand on a device's handle, and the device's driver. It is a mass that a spring draws
/// from one random place to the next, sometimes faster than any working hand. It gives way to the
/// motor. The public flags make the driver fail.
class ModelledHand : public Device {
 public:
  static constexpr DeviceLimits kPeak{.force = 7.0, .moment = 0.3};
  static constexpr DeviceLimits kContinuous{.force = 1.8, .moment = 0.1};

  explicit ModelledHand(std::uint64_t seed) : rng_(seed) {}

  void Start() noexcept override {}
  /// Moves on by a millisecond, then returns its pose.
  Anchor Read() noexcept override;
  void Render(const Wrench& F_D_W) noexcept override { given_ = F_D_W; }
  DeviceCapabilities capabilities() const noexcept override {
    DeviceCapabilities can;
    can.peak = kPeak;
    can.continuous = kContinuous;
    return can;
  }
  bool failed() const noexcept override { return fails; }
  bool stop_button() const noexcept override { return pressed; }

  /// Makes the hand stay where it is.
  void Rest() noexcept { rests_ = true; }

  bool fails = false;     // the driver is in trouble
  bool nonsense = false;  // the driver's pose is not a number
  bool pressed = false;   // the button for an emergency stop is pressed
  const Wrench& given() const noexcept { return given_; }
  const Anchor& handle() const noexcept { return handle_; }

 private:
  void Aim() noexcept;

  SeededRandom rng_;
  Wrench given_;
  Anchor handle_;
  Pose from_;
  Pose to_;
  double way_s_ = 1;   // length of the present move
  double gone_s_ = 1;  // time gone of the present move
  bool rests_ = false;
};

}  // namespace tandem
