#include "collab/simulated/hands/checkers/view_checker.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

bool IsFinite(const PlainPose& X) {
  const auto finite = [](double x) {
    return std::isfinite(x);
  };
  return std::ranges::all_of(X.p_W, finite) && std::ranges::all_of(X.q_W, finite);
}

bool SameAs(const PlainPose& plain, const Pose& X) {
  return plain.p_W[0] == X.p.x() && plain.p_W[1] == X.p.y() && plain.p_W[2] == X.p.z();
}

}  // namespace

void ViewChecker::OnWoken(std::int64_t now_ns) {
  for (auto& [host, seen_ns] : seen_ns_) seen_ns = now_ns;
}

void ViewChecker::OnSnapshot(const std::vector<HostId>& hosts, const ControllerSnapshot& snapshot,
                             const TrueHolders& holders, std::int64_t now_ns) {
  for (const HostId host : hosts) {
    const auto seen = seen_ns_.find(host);
    if (seen != seen_ns_.end()) seen->second = now_ns;
  }
  CheckBodies(snapshot);
  CheckHolders(snapshot, holders, now_ns);
}

void ViewChecker::CheckBodies(const ControllerSnapshot& snapshot) {
  if (snapshot.bodies.size() != model_->scene.bodies.size()) {
    return violations_->Add("a snapshot lacks a body", id_);
  }
  const SnapshotHand& hand = snapshot.hand;
  bool finite = IsFinite(hand.X_WG) && IsFinite(hand.goal) && IsFinite(hand.limited_goal) &&
                std::isfinite(hand.felt_N);
  for (const SnapshotBody& body : snapshot.bodies) {
    finite = finite && IsFinite(body.X_WB) && IsFinite(body.X_W);
  }
  if (!finite) return violations_->Add("a snapshot is not finite", id_);
  const Frame& frame = frames_[snapshot.frame % kKept];
  if (snapshot.frame == 0) return;
  if (frame.number != snapshot.frame) return violations_->Add("a snapshot is of long ago", id_);
  for (std::size_t i = 0; i < snapshot.bodies.size(); ++i) {
    const int moving = model_->body_index[i];
    if (moving < 0) continue;
    const auto b = static_cast<std::size_t>(moving);
    const bool right = SameAs(snapshot.bodies[i].X_WB, frame.poses[b]) &&
                       snapshot.bodies[i].in_hand == (frame.held == moving);
    if (!right) violations_->Add("a snapshot has a body elsewhere", id_, model_->bodies[b].name);
  }
}

void ViewChecker::CheckHolders(const ControllerSnapshot& snapshot, const TrueHolders& holders,
                               std::int64_t now_ns) {
  if (snapshot.frame == 0 || now_ns - holders.since_ns < holders.known_after_ns) return;
  for (std::size_t i = 0; i < snapshot.bodies.size(); ++i) {
    const int moving = model_->body_index[i];
    if (moving < 0) continue;
    std::vector<PeerId> reported = snapshot.bodies[i].holders;
    std::ranges::sort(reported);
    if (reported == holders.of[static_cast<std::size_t>(moving)]) continue;
    violations_->Add("a snapshot has the wrong holders", id_,
                     model_->bodies[static_cast<std::size_t>(moving)].name);
  }
}

void ViewChecker::Check(std::uint64_t frame, const World& world, int held,
                        const std::vector<bool>& parked, std::int64_t now_ns) {
  Frame& kept = frames_[frame % kKept];
  kept.number = frame;
  kept.held = held;
  kept.poses.clear();
  left_.resize(parked.size());
  for (std::size_t b = 0; b < parked.size(); ++b) {
    const Pose& X_WB = world.state(b).X_WB;
    kept.poses.push_back(X_WB);
    Left& left = left_[b];
    const bool let_go = held_ == static_cast<int>(b) && held != held_;
    if (let_go)
      left = {true, X_WB, now_ns + (model_->scene.bodies[model_->object[b]].shared ? kNewsNs : 0)};
    left.watched = left.watched && parked[b];
    if (now_ns < left.from_ns) left.X_WB = X_WB;
    const double moved = (X_WB.p - left.X_WB.p).norm();
    if (left.watched && moved > 1e-9) {
      violations_->Add("a body that was let go of moves", id_,
                       model_->bodies[b].name + Text(", by %.3f mm", 1e3 * moved));
    }
  }
  held_ = held;
  for (const auto& [host, seen_ns] : seen_ns_) {
    if (now_ns - seen_ns > kMostNs) violations_->Add("a host sees no snapshot", id_);
  }
}

}  // namespace tandem
