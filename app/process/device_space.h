#pragma once

#include <cmath>
#include <memory>
#include <mutex>

#include "app/process/device_process.h"
#include "engine/haptics/workspace.h"

namespace tandem {

/// A device in a process of its own, and its mapping into the scene. Options, orders and hosts
/// change the mapping, each on a thread of its own. This object outlives the scenes that are loaded
/// one after the other. So do an emergency stop at the device, a fault and the warmth of its
/// motors.
class DeviceSpace {
 public:
  /// The mapping for a person who looks along W's y axis: V's x, y and z axes are W's x, z and -y.
  /// It holds for a device with axes of its own until a window says how its user looks.
  static inline const Quat kFacingNorth{M_SQRT1_2, M_SQRT1_2, 0, 0};

  explicit DeviceSpace(const WorkspaceOrder& order) : order_(order) {}

  /// Returns the device process; null: there is none yet. For the thread that joins sessions.
  DeviceProcess* process() const noexcept { return process_.get(); }
  void Keep(std::unique_ptr<DeviceProcess> process) {
    process_ = std::move(process);
    handle_ = process_->MakeDevice();
    if (!process_->capabilities().in_scene && order_.q_WV.isApprox(Quat::Identity())) {
      order_.q_WV = kFacingNorth;
    }
  }
  /// Returns the device mapped into the scene. It must not outlive this object.
  std::unique_ptr<Workspace> MapInto() {
    const std::lock_guard lock(mutex_);
    auto workspace = std::make_unique<Workspace>(*handle_, order_);
    workspace_ = workspace.get();
    return workspace;
  }
  /// Forgets the workspace of MapInto(), because its scene is about to go.
  void Forget() {
    const std::lock_guard lock(mutex_);
    workspace_ = nullptr;
  }

  double scale() {
    const std::lock_guard lock(mutex_);
    return order_.scale;
  }
  /// Sets the scale of the next scene. Command::Kind::kScale changes that of the present one.
  void Rescale(double scale) {
    const std::lock_guard lock(mutex_);
    order_.scale = scale;
  }
  /// Changes the mapping. Returns false if no device in a process of its own is in hand.
  bool Change(const WorkspaceChange& change) {
    const std::lock_guard lock(mutex_);
    if (workspace_ == nullptr) return false;
    change.ApplyTo(order_);
    workspace_->orders().back() = order_;
    workspace_->orders().Publish();
    return true;
  }

 private:
  std::unique_ptr<DeviceProcess> process_;
  std::unique_ptr<Device> handle_;
  std::mutex mutex_;
  WorkspaceOrder order_;
  Workspace* workspace_ = nullptr;
};

}  // namespace tandem
