#pragma once

#include "engine/base/spatial.h"
#include "engine/dynamics/virtual_coupling.h"
#include "engine/safety/device_limits.h"

namespace tandem {

/// A hand's device: gives the pose of its handle, takes the force it is to render. Used by the
/// haptic thread alone, once a frame in this order; neither call may block, allocate or throw.
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
  virtual DeviceLimits limits() const noexcept { return {}; }
};

}  // namespace tandem
