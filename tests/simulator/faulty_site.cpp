#include "tests/simulator/faulty_site.h"

#include <limits>

#include "tests/simulator/injected_hand_faults.h"

namespace tandem {

void FaultySite::ChangeSnapshot(ControllerSnapshot& snapshot) {
  if (Injected(HandFault::kSnapshotStands)) {
    if (first_.frame == 0) first_ = snapshot;
    if (snapshot.frame % 2 == 0) snapshot = first_;
  }
  if (Injected(HandFault::kBodyElsewhere)) snapshot.bodies[2].X_WB.p_W[0] += 1e-3;
  if (Injected(HandFault::kBodyMissing)) snapshot.bodies.pop_back();
  if (Injected(HandFault::kSnapshotNoNumber)) {
    snapshot.bodies[1].X_WB.p_W[1] = std::numeric_limits<double>::quiet_NaN();
  }
  if (!Injected(HandFault::kHolderMissing)) return;
  for (SnapshotBody& body : snapshot.bodies) body.holders.clear();
}

void FaultySite::MoveParkedBodies(PeerNode& node) const {
  const Ownership& ownership = node.peer().ownership();
  for (std::size_t b = 0; b < node.world().model().bodies.size(); ++b) {
    if (!ownership.Parks(b)) continue;
    const Pose X_WB = node.world().state(b).X_WB;
    node.world().Place(b, {X_WB.q, X_WB.p + Vec3(1e-5, 0, 0)});
  }
}

}  // namespace tandem
