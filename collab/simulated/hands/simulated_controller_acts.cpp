#include "collab/simulated/hands/simulated_controller.h"

// The orders of the server to its peer.

namespace tandem {

bool SimulatedController::Order(const Command& command) {
  return node().peer().commands().TryPush(command);
}

void SimulatedController::Tell(const GoalOrder& order) {
  reported_ = order;
  goals_->newest.back() = order;
  goals_->newest.Publish();
}

void SimulatedController::Begin(std::uint64_t job, const ControlRequest&) {
  // some jobs are done at once, others refused after a while
  jobs_.push_back({job, session_->now_ns() + rng_.Whole(0, 1500) * 1'000'000, rng_.Chance(0.5)});
}

void SimulatedController::StopDevice(bool stop) {
  using Kind = Command::Kind;
  node().peer().commands().TryPush({.kind = stop ? Kind::kStop : Kind::kResume});
}

bool SimulatedController::ChangeWorkspace(const WorkspaceChange& change) {
  if (space_ == nullptr) return false;
  change.ApplyTo(space_order_);
  space_->orders().back() = space_order_;
  space_->orders().Publish();
  return true;
}

}  // namespace tandem
