#include "collab/simulated/hands/controller_site.h"

// The orders of the server to its peer.

namespace tandem {

bool ControllerSite::Order(const Command& command) {
  return node().peer().commands().TryPush(command);
}

void ControllerSite::Tell(const GoalOrder& order) {
  told_ = order;
  goals_->newest.back() = order;
  goals_->newest.Publish();
}

void ControllerSite::Begin(std::uint64_t job, const ControlRequest&) {
  // some jobs are done at once, others refused after a while
  jobs_.push_back({job, session_->now_ns() + dice_.Whole(0, 1500) * 1'000'000, dice_.Chance(0.5)});
}

void ControllerSite::StopDevice(bool stop) {
  using Kind = Command::Kind;
  node().peer().commands().TryPush({.kind = stop ? Kind::kStop : Kind::kResume});
}

bool ControllerSite::ChangeWorkspace(const WorkspaceChange& change) {
  if (space_ == nullptr) return false;
  change.ApplyTo(space_order_);
  space_->orders().back() = space_order_;
  space_->orders().Publish();
  return true;
}

}  // namespace tandem
