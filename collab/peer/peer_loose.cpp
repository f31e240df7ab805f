#include "collab/peer/peer.h"

// Free bodies in no hand: which of them this peer simulates, and the states that it sends of them.

namespace tandem {

namespace {

constexpr double kOutOfScene = 20;  // m from its initial place: a loose body falls no farther
constexpr std::int64_t kRestNs = 200'000'000;  // without motion: then a loose body stands
constexpr double kRestSpeed = 1e-3;            // m/s; at any of its points

}  // namespace

void Peer::NoteTouches() noexcept {
  if (!attached_) return;
  const auto held = static_cast<InstanceIndex>(held_);
  for (std::size_t pair = 0; pair < world_->pair_count(); ++pair) {
    const InstanceIndex shell = world_->shell_of(pair);
    const InstanceIndex map = world_->voxmap_of(pair);
    if (!world_->pushes(pair) || map == kFixture || (shell != held && map != held)) continue;
    ownership_.NoteTouch(shell == held ? map : shell);
  }
}

bool Peer::IsSimulatedLoose(std::size_t body) const noexcept {
  const WorldModel& model = world_->model();
  if (!model.scene.bodies[model.object[body]].free || static_cast<int>(body) == held_) return false;
  const Vec3 fell = world_->state(body).X_WB.p - model.bodies[body].X_WB0.p;
  return ownership_.Parks(body) && !ownership_.listening() && fell.norm() < kOutOfScene;
}

void Peer::PrepareLoose() noexcept {
  const WorldModel& model = world_->model();
  for (std::size_t b = 0; b < body_count(); ++b) {
    if (!model.scene.bodies[model.object[b]].free) continue;
    const bool loose = IsSimulatedLoose(b);
    const bool ours = loose || static_cast<int>(b) == held_;
    if (loose) {
      remote_.TakeOver(b, inputs_);
    } else {
      free_[b].moved_ns = 0;
    }
    const PeerId answers = ownership_.authority(b);
    if (free_[b].ours && !ours && answers != options_.id) {
      remote_.HandOver(b, answers, world_->state(b), inputs_);
    }
    free_[b].ours = ours;
  }
}

bool Peer::IsLoose(std::size_t body, std::int64_t now_ns) const noexcept {
  return free_[body].moved_ns != 0 && now_ns - free_[body].moved_ns < kRestNs;
}

void Peer::PublishLoose(std::int64_t now_ns, Outbox& out) noexcept {
  out.is_loose = false;
  const std::size_t count = body_count();
  for (std::size_t b = 0; b < count; ++b) {
    if (!free_[b].ours || static_cast<int>(b) == held_) continue;
    const auto& [w, v] = world_->state(b).V_WB;
    const double speed = v.norm() + w.norm() * world_->model().bodies[b].radius;
    if (speed > kRestSpeed) free_[b].moved_ns = now_ns;
  }
  for (std::size_t i = 0; i < count && !out.is_loose; ++i) {
    const std::size_t b = (next_loose_ + i) % count;
    if (!IsLoose(b, now_ns)) continue;
    next_loose_ = b + 1;
    const RigidState& state = world_->state(b);
    out.is_loose = true;
    out.loose = {.peer = options_.id,
                 .object = world_->model().object[b],
                 .epoch = ownership_.epoch(b),
                 .seq = seq_,
                 .flags = kStateLoose,
                 .sample_ns = now_ns,
                 .X_WB = state.X_WB,
                 .V_WB = state.V_WB,
                 .contact_B_W = {}};
  }
}

}  // namespace tandem
