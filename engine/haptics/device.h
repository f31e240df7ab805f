#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "engine/dynamics/virtual_coupling.h"
#include "engine/safety/device_limits.h"
#include "engine/safety/safety_state.h"

namespace tandem {

/// What a device can take and give. The default is a device that bears all that Tandem asks.
struct DeviceCapabilities {
  static constexpr double kAny = std::numeric_limits<double>::infinity();

  int freedoms_in = 6;      // degrees of freedom that it measures
  int freedoms_out = 6;     // that its motors drive; 0: no force feedback
  DeviceLimits peak;        // N, N m that it gives for a moment
  DeviceLimits continuous;  // for ever
  Bounds workspace;         // m, of the handle, in W as the driver has it; empty: no bounds
  double rate_hz = 1000;    // of its own loop
  // the largest gains of a coupling that it renders without shaking
  double stiffness = kAny;           // N/m
  double damping = kAny;             // N s/m
  double rotation_stiffness = kAny;  // N m/rad
  double rotation_damping = kAny;    // N m s/rad
  bool asks_us = false;  // a thread of its vendor asks for the force: it comes a period later
  bool in_scene = true;  // its axes are W's; else x right, y up, z to the person
};

/// How old what a vendor's thread gets is when it first asks for it (VendorMailbox).
struct AskedTimes {
  std::uint64_t count = 0;
  std::int64_t mean_ns = 0;
  std::int64_t max_ns = 0;
};

/// A hand's device: gives the pose of its handle, takes the force that it is to render. Used by the
/// haptic thread alone, once a frame in this order; no call may block, allocate or throw.
class Device {
 public:
  virtual ~Device() = default;
  /// Lets the user begin; until then a scripted hand rests at the start.
  virtual void Start() noexcept = 0;
  /// The handle's pose and twist in W.
  virtual Anchor Read() noexcept = 0;
  /// The wrench on the handle about its origin, in W: the opposite of what its coupling put on the
  /// body.
  virtual void Render(const Wrench& F_D_W) noexcept = 0;
  /// Emergency stop: no force from now on, until Resume(). A driver's Stop() writes zero to the
  /// motors at once; a signal handler may call it, and another thread while Read() hangs.
  virtual void Stop() noexcept {}
  virtual void Resume() noexcept {}
  /// Of a handle that is mapped into the scene: metres there a metre of its own.
  virtual void Rescale(double) noexcept {}
  /// Before each Read(): whether a part is in the hand.
  virtual void Holding(bool) noexcept {}
  virtual DeviceCapabilities capabilities() const noexcept { return {}; }
  /// Whether the device is in trouble: unplugged, too hot, not calibrated.
  virtual bool failed() const noexcept { return false; }
  /// Whether its button for an emergency stop is pressed.
  virtual bool stop_button() const noexcept { return false; }
  /// Whether its button is pressed by which the handle is moved alone (Workspace).
  virtual bool clutch_button() const noexcept { return false; }
  /// What a guard beyond the controller's own says; without one: nothing held back.
  virtual DeviceSafety safety() const noexcept { return {}; }
  /// Of a device that asks us: what that costs.
  virtual AskedTimes asked_times() const noexcept { return {}; }
};

/// A gain that a device bears, as claimed; infinity: any. What is no number or not positive counts
/// as zero.
inline double SoundGain(double claimed) noexcept {
  return claimed > 0 ? claimed : 0.0;
}
/// What a person is told of gains that `who` claims and that are not taken as they are; empty: they
/// are.
std::string WhatGainsBecame(const std::string& who, const DeviceCapabilities& can);

/// `gains`, no larger than the device bears.
CouplingGains BorneBy(const DeviceCapabilities& device, CouplingGains gains) noexcept;

}  // namespace tandem
