#pragma once

#include <cstdint>

#include "collab/controller/snapshot.h"
#include "collab/peer/peer_node.h"

namespace tandem {

/// The injected fault of the session at a simulated controller, where it takes more than a line of
/// collab/simulated/hands.
class FaultySite {
 public:
  /// Returns whether the present answer is one that a fault of answers changes, one in five.
  bool TakesAnswer() { return ++answers_ % 5 == 0; }
  void ChangeSnapshot(ControllerSnapshot& snapshot);
  /// Moves the bodies that stand, each by 0.01 mm.
  void MoveParkedBodies(PeerNode& node) const;

 private:
  std::uint64_t answers_ = 0;
  ControllerSnapshot first_;  // first snapshot of all
};

}  // namespace tandem
