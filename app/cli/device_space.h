#pragma once

#include <mutex>

#include "engine/haptics/workspace.h"

namespace tandem {

/// How the user wants the device to reach the scene, as said by options, orders and hosts, each on
/// a thread of its own; it outlives the scenes that are loaded one after the other.
class DeviceSpace {
 public:
  explicit DeviceSpace(const WorkspaceOrder& order) : order_(order) {}

  const WorkspaceOrder& order() const noexcept { return order_; }
  /// From now on that one is told of changes; null: none.
  void Use(Workspace* workspace) {
    const std::lock_guard lock(mutex_);
    workspace_ = workspace;
    Tell();
  }
  /// False: no device in a process of its own is in the hand.
  bool Change(const WorkspaceChange& change) {
    const std::lock_guard lock(mutex_);
    if (workspace_ == nullptr) return false;
    change.ApplyTo(order_);
    Tell();
    return true;
  }

 private:
  void Tell() {
    if (workspace_ == nullptr) return;
    workspace_->orders().back() = order_;
    workspace_->orders().Publish();
  }

  std::mutex mutex_;
  WorkspaceOrder order_;
  Workspace* workspace_ = nullptr;
};

}  // namespace tandem
