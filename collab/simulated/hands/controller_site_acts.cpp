#include <cmath>
#include <limits>

#include "collab/simulated/hands/controller_site.h"
#include "collab/simulated/hands/planted_hand_faults.h"

// The orders of the server to its peer. Faults are injected into them here.

namespace tandem {

bool ControllerSite::Order(const Command& command) {
  if (server_.stopped() && PlantedInHand(HandFault::kStopUnheard)) return true;
  return node().peer().commands().TryPush(command);
}

void ControllerSite::Tell(const GoalOrder& order) {
  if (PlantedInHand(HandFault::kHoldForgotten) && order.input_seq != told_.input_seq &&
      order.X_WG.p == facts_.handle.p) {
    return;
  }
  told_ = order;
  GoalOrder& out = goals_->newest.back();
  out = order;
  if (PlantedInHand(HandFault::kNoLead)) out.limits.force *= 10;
  goals_->newest.Publish();
}

void ControllerSite::Begin(std::uint64_t job, const ControlRequest&) {
  // some jobs are done at once, others refused after a while
  jobs_.push_back({job, session_->now_ns() + dice_.Whole(0, 1500) * 1'000'000, dice_.Chance(0.5)});
}

void ControllerSite::StopDevice(bool stop) {
  using Kind = Command::Kind;
  if (stop && PlantedInHand(HandFault::kStopUnheard)) return;
  node().peer().commands().TryPush({.kind = stop ? Kind::kStop : Kind::kResume});
}

bool ControllerSite::ChangeWorkspace(const WorkspaceChange& change) {
  if (space_ == nullptr) return false;
  change.ApplyTo(space_order_);
  space_->orders().back() = space_order_;
  space_->orders().Publish();
  return true;
}

void ControllerSite::PlantInSnapshot(ControllerSnapshot& snapshot) {
  if (PlantedInHand(HandFault::kSnapshotStands)) {
    if (first_.frame == 0) first_ = snapshot;
    if (snapshot.frame % 2 == 0) snapshot = first_;
  }
  if (PlantedInHand(HandFault::kBodyElsewhere)) snapshot.bodies[2].X_WB.p_W[0] += 1e-3;
  if (PlantedInHand(HandFault::kBodyMissing)) snapshot.bodies.pop_back();
  if (PlantedInHand(HandFault::kSnapshotNoNumber)) {
    snapshot.bodies[1].X_WB.p_W[1] = std::numeric_limits<double>::quiet_NaN();
  }
  if (!PlantedInHand(HandFault::kHolderMissing)) return;
  for (SnapshotBody& body : snapshot.bodies) body.holders.clear();
}

void ControllerSite::PlantInFrame() {
  if (!PlantedInHand(HandFault::kSlipsWhenLetGo)) return;
  const Holdings& holdings = node().peer().holdings();
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    if (!holdings.Parks(b)) continue;
    const Pose X_WB = node().world().state(b).X_WB;
    node().world().Place(b, {X_WB.q, X_WB.p + Vec3(1e-5, 0, 0)});
  }
}

}  // namespace tandem
