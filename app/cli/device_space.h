#pragma once

#include <cmath>
#include <memory>
#include <mutex>

#include "app/cli/device_process.h"
#include "engine/haptics/workspace.h"

namespace tandem {

/// A device in a process of its own, and how the user wants it to reach the scene, as said by
/// options, orders and hosts, each on a thread of its own. It outlives the scenes that are loaded
/// one after the other: so do an emergency stop at the device, a fault, the warmth of its motors.
class DeviceSpace {
 public:
  /// A person who looks along W's y axis: V's x, y and z axes are W's x, z and -y. So a device of
  /// its own axes is mapped until a window says how its user looks.
  static inline const Quat kFacingNorth{M_SQRT1_2, M_SQRT1_2, 0, 0};

  explicit DeviceSpace(const WorkspaceOrder& order) : order_(order) {}

  /// Of the thread that joins sessions. Null: there is none yet.
  DeviceProcess* process() const noexcept { return process_.get(); }
  void Keep(std::unique_ptr<DeviceProcess> process) {
    process_ = std::move(process);
    handle_ = process_->MakeDevice();
    if (!process_->capabilities().in_scene && order_.q_WV.isApprox(Quat::Identity())) {
      order_.q_WV = kFacingNorth;
    }
  }
  /// The device, mapped into the scene; must not outlive this.
  std::unique_ptr<Workspace> MapInto() {
    const std::lock_guard lock(mutex_);
    auto workspace = std::make_unique<Workspace>(*handle_, order_);
    workspace_ = workspace.get();
    return workspace;
  }
  /// The scene with that one is about to go.
  void Forget() {
    const std::lock_guard lock(mutex_);
    workspace_ = nullptr;
  }

  double scale() {
    const std::lock_guard lock(mutex_);
    return order_.scale;
  }
  /// The scale of the next scene; the present one goes by Command::Kind::kScale.
  void Rescale(double scale) {
    const std::lock_guard lock(mutex_);
    order_.scale = scale;
  }
  /// False: no device in a process of its own is in the hand.
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
