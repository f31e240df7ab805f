#pragma once

#include <cstdint>

#include "collab/controller/requests.h"
#include "collab/session/command.h"
#include "engine/haptics/goal_device.h"
#include "engine/haptics/workspace.h"

namespace tandem {

/// Orders of a controller's server to the peer of its own process, or to a test's. None of them
/// waits.
class ControlledPeer {
 public:
  virtual ~ControlledPeer() = default;
  /// Returns false if too many orders wait.
  virtual bool Order(const Command& command) = 0;
  /// Passes an order to the hand that hosts move.
  virtual void Tell(const GoalOrder& order) = 0;
  /// Begins a slow request: a LoadSceneRequest, LoadMeshRequest, VoxelizeRequest,
  /// MeasureDistancesRequest or SaveRequest. ControlServer::OnDone() gets its result.
  virtual void Begin(std::uint64_t job, const ControlRequest& request) = 0;
  /// Gives no force to any device until called with false.
  virtual void StopDevice(bool stop) = 0;
  /// Changes the workspace of the controller's device. Returns false if no device in a process of
  /// its own is in hand.
  virtual bool ChangeWorkspace(const WorkspaceChange& change) = 0;
  virtual void Quit() = 0;
};

}  // namespace tandem
