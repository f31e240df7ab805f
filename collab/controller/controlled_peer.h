#pragma once

#include <cstdint>

#include "collab/command.h"
#include "collab/controller/requests.h"
#include "engine/haptics/goal_device.h"
#include "engine/haptics/workspace.h"

namespace tandem {

/// What a controller's server acts on: the peer of its own process, or a test's. None of these
/// waits.
class ControlledPeer {
 public:
  virtual ~ControlledPeer() = default;
  /// False: too many orders wait.
  virtual bool Order(const Command& command) = 0;
  /// To the hand that hosts move.
  virtual void Tell(const GoalOrder& order) = 0;
  /// Begins what takes long: a LoadSceneRequest, LoadMeshRequest, VoxelizeRequest or SaveRequest.
  /// ControlServer::OnDone() has what came of it.
  virtual void Begin(std::uint64_t job, const ControlRequest& request) = 0;
  /// No force to any device until false.
  virtual void StopDevice(bool stop) = 0;
  /// Of the device at the controller; false: there is none.
  virtual bool ChangeWorkspace(const WorkspaceChange& change) = 0;
  virtual void Quit() = 0;
};

}  // namespace tandem
