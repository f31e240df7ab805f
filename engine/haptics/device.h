#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "engine/dynamics/virtual_coupling.h"
#include "engine/safety/device_limits.h"
#include "engine/safety/safety_state.h"

namespace tandem {

/// The input and output of a device. The default is a device that bears all that Tandem asks.
struct DeviceCapabilities {
  static constexpr double kAny = std::numeric_limits<double>::infinity();

  int freedoms_in = 6;      // degrees of freedom of its input
  int freedoms_out = 6;     // degrees of freedom that its motors drive; 0: no force feedback
  DeviceLimits peak;        // N, N m for a moment
  DeviceLimits continuous;  // N, N m for ever
  Bounds workspace;       // workspace of the handle, in W as the driver has it, m; empty: no bounds
  double rate_hz = 1000;  // rate of its own loop, Hz
  // greatest gains of a coupling that it renders without shaking
  double stiffness = kAny;           // N/m
  double damping = kAny;             // N s/m
  double rotation_stiffness = kAny;  // N m/rad
  double rotation_damping = kAny;    // N m s/rad
  bool asks_us = false;  // a thread of its vendor fetches the force: it comes a period later
  bool in_scene = true;  // its axes are W's; else x right, y up, z to the person
};

/// Ages of the forces that a vendor's thread gets when it first fetches them (VendorMailbox).
struct ForceFetchTimes {
  std::uint64_t count = 0;
  std::int64_t mean_ns = 0;
  std::int64_t max_ns = 0;
};

/// A hand's device: gives the pose of its handle and takes the force to render. Used by the haptic
/// thread alone, once a frame in this order. No call may block, allocate or throw.
class Device {
 public:
  virtual ~Device() = default;
  /// Lets the user begin; until then a scripted hand rests at the start.
  virtual void Start() noexcept = 0;
  /// Returns the handle's pose and twist in W.
  virtual Anchor Read() noexcept = 0;
  /// Renders the wrench on the handle about its origin, in W: the opposite of the wrench of its
  /// coupling on the body.
  virtual void Render(const Wrench& F_D_W) noexcept = 0;
  /// Emergency stop: no force until Resume(). A driver's Stop() writes zero to the motors at once.
  /// A signal handler may call it, and another thread while Read() hangs.
  virtual void Stop() noexcept {}
  virtual void Resume() noexcept {}
  /// Sets the scale of a handle that is mapped into the scene: metres there per metre of its own.
  virtual void Rescale(double) noexcept {}
  /// Tells the device whether a part is in the hand; called before each Read().
  virtual void Holding(bool) noexcept {}
  virtual DeviceCapabilities capabilities() const noexcept { return {}; }
  /// Tells whether the device is in trouble: unplugged, too hot, not calibrated.
  virtual bool failed() const noexcept { return false; }
  /// Tells whether its button for an emergency stop is pressed.
  virtual bool stop_button() const noexcept { return false; }
  /// Tells whether its clutch button, which moves the handle alone (Workspace), is pressed.
  virtual bool clutch_button() const noexcept { return false; }
  /// Returns the state of a guard besides the controller's own; without one: no limits.
  virtual DeviceSafety safety() const noexcept { return {}; }
  /// Returns the ages of the forces, for a device whose vendor's thread fetches them.
  virtual ForceFetchTimes fetch_times() const noexcept { return {}; }
};

/// Returns a gain that a device bears, as claimed; infinity: any. A value that is not a number or
/// not positive counts as zero.
inline double ValidGain(double claimed) noexcept {
  return claimed > 0 ? claimed : 0.0;
}
/// Returns a text for a person on gains that `who` claims and that are not taken as they are; empty
/// if they are.
std::string DescribeGainChange(const std::string& who, const DeviceCapabilities& can);

/// Returns `gains`, no larger than the device bears.
CouplingGains LimitGains(const DeviceCapabilities& device, CouplingGains gains) noexcept;

}  // namespace tandem
