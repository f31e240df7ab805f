#include "collab/simulated/checkers/motion_checker.h"

#include <algorithm>

#include "collab/simulated/network/box_gap.h"
#include "collab/simulated/network/light_scene.h"

namespace tandem {

namespace {

bool IsFinite(const RigidState& state) {
  return state.X_WB.p.allFinite() && state.X_WB.q.coeffs().allFinite() &&
         state.V_WB.v.allFinite() && state.V_WB.w.allFinite();
}

SolidBox BoxOf(const Pose& X_WB) {
  return {X_WB, Vec3::Constant(0.5 * kLightSceneBox)};
}

}  // namespace

void MotionChecker::OnHostileEvent(const Event& event) {
  placed_.resize(model_->bodies.size());
  if (event.object >= model_->body_index.size() || model_->body_index[event.object] < 0) return;
  placed_[static_cast<std::size_t>(model_->body_index[event.object])] = {now_ns_, true};
}

void MotionChecker::SeePlaced(SimulatedSession& session) {
  now_ns_ = session.now_ns();
  placed_.resize(model_->bodies.size());
  for (std::size_t b = 0; hostile_ != 0 && b < model_->bodies.size(); ++b) {
    for (std::size_t m = 0; m < session.size(); ++m) {
      if (!session.present(m)) continue;
      const Ownership& ownership = session.node(m).peer().ownership();
      if (ownership.authority(b) == hostile_) placed_[b] = {now_ns_, true};
      if (ownership.held() == static_cast<int>(b)) placed_[b].untouched = false;
    }
  }
}

bool MotionChecker::IsPlaced(std::size_t body) const {
  constexpr std::int64_t kShown = 5'000'000'000;  // time until all peers are shown it, over the
                                                  // longest ways
  const Placed& placed = placed_[body];
  return placed.untouched || (placed.ns != 0 && now_ns_ - placed.ns < kShown);
}

void MotionChecker::Check(SimulatedSession& session) {
  SeePlaced(session);
  seen_.resize(session.size());
  held_.resize(session.size(), -1);
  in_plate_.resize(session.size(), false);
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (!session.present(m) || session.halted(m)) continue;
    const PeerId id = session.id(m);
    PeerNode& node = session.node(m);
    const World& world = node.world();
    std::vector<Seen>& seen = seen_[m];
    seen.resize(model_->bodies.size());
    bool sound = true;
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      sound = sound && IsFinite(world.state(b));
    }
    if (!sound) {
      violations_->Add("a simulation is not finite", id);
      continue;
    }
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      const RigidState& state = world.state(b);
      const double moved = (state.X_WB.p - seen[b].X_WB.p).norm();
      const bool held = node.peer().held_state() == &state;
      const double explained = fast_ ? 1.1 * kFrame * state.V_WB.v.norm() : 0.0;
      if (held && seen[b].known && moved > std::max(model_->scene.voxel_size, explained)) {
        violations_->Add("a body in hand jumps", id, Text("by %.2f mm", 1e3 * moved));
      }
    }
    // until the hand has grasped it, the body moves as a mirror does
    const bool grasped =
        node.peer().report().hand_B_W.f != Vec3::Zero() || node.peer().separation().guiding();
    const int held = grasped ? node.peer().ownership().held() : -1;
    if (held >= 0) CheckHeld(session, m, static_cast<std::size_t>(held));
    held_[m] = held;
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      seen[b].known = true;
      seen[b].X_WB = world.state(b).X_WB;
    }
  }
}

void MotionChecker::CheckHeld(SimulatedSession& session, std::size_t member, std::size_t held) {
  const PeerId id = session.id(member);
  const World& world = session.node(member).world();
  const SolidBox in_hand = BoxOf(world.state(held).X_WB);
  const double deepest = kMostOverlap;
  const double above = BoxGap(in_hand, LightScenePlate());
  in_plate_[member] = above < 0 && (in_plate_[member] || held_[member] != static_cast<int>(held));
  if (above < -deepest && !in_plate_[member]) {
    violations_->Add("what the hand holds is in the plate", id);
  }
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    if (b == held) continue;
    const Pose& X_WB = world.state(b).X_WB;
    Seen& seen = seen_[member][b];
    const double gap = BoxGap(in_hand, BoxOf(X_WB));
    const bool taken_now = held_[member] != static_cast<int>(held);
    const bool was_near = seen.near && !taken_now;
    seen.near = gap < model_->scene.voxel_size;
    seen.excused = gap < 0 && (seen.excused || taken_now || IsPlaced(b));
    if (seen.excused) continue;
    if (gap < -deepest) {
      violations_->Add("a body is in the one that the hand holds", id,
                       model_->bodies[b].name + Text(", by %.2f mm", -1e3 * gap));
    }
    if (!was_near || !seen.known) continue;
    const double surface = (X_WB.p - seen.X_WB.p).norm() +
                           X_WB.q.angularDistance(seen.X_WB.q) * model_->bodies[b].radius;
    if (surface > kMostMirrorTravel) {
      violations_->Add("a mirror pushes in by more than its share", id,
                       model_->bodies[b].name + Text(", %.3f mm in a frame", 1e3 * surface));
    }
  }
}

}  // namespace tandem
