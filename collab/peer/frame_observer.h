#pragma once

#include <cstdint>

#include "collab/session/command.h"
#include "collab/session/membership.h"
#include "engine/dynamics/virtual_coupling.h"

namespace tandem {

/// Receives all inputs of a haptic frame, in the order in which the frame uses them, so that a run
/// can be repeated. Called by the haptic thread: no call may allocate, lock or throw.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  virtual void Begin(std::int64_t now_ns, double capacity) noexcept = 0;
  virtual void OnReceived(const MembershipChange& change) noexcept = 0;
  virtual void OnReceived(const Event& event) noexcept = 0;
  virtual void OnReceived(const ObjectState& state) noexcept = 0;
  virtual void OnReceived(const CouplingLinks& links) noexcept = 0;
  virtual void OnCommand(const Command& command) noexcept = 0;
  virtual void OnDevice(const Anchor& device) noexcept = 0;
  /// `state_hash`: Hash64 over the states of all moving bodies.
  virtual void End(std::uint64_t state_hash) noexcept = 0;
};

}  // namespace tandem
