#include "collab/peer/peer.h"

// Output of a peer after a frame: to the other peers, to viewers and to its own program.

namespace tandem {

namespace {

constexpr std::int64_t kParkedPeriodNs = 200'000'000;

}  // namespace

void Peer::FillOutbox(std::int64_t now_ns, Outbox& out) noexcept {
  out.seq = ++seq_;
  telemetry_.FillView(now_ns, seq_, {.body = held_, .shared = shared()}, out.view);
  out.holds = held_ >= 0 && !ownership_.listening();
  if (!out.holds) return;
  validator_.NoteSent(now_ns);
  const auto body = static_cast<std::size_t>(held_);
  const RigidState& state = *held_state();
  out.state = {.peer = options_.id,
               .object = world_->model().object[body],
               .epoch = ownership_.own_epoch(body),
               .seq = seq_,
               .flags = report_.flags | telemetry_.limit_flags(),
               .sample_ns = now_ns,
               .X_WB = state.X_WB,
               .V_WB = report_.waited > 0 ? Twist{} : state.V_WB,  // the body stands
               .contact_B_W = report_.contact_B_W};
  out.links.from = options_.id;
  out.links.object = kNoObject;
  out.links.seq = seq_;
  out.links.sample_ns = now_ns;
  out.links.count = 0;
  if (shared_) shared_->Describe(now_ns, seq_, report_, out.links);
  round_trips_.Append(now_ns, out.links);
  out.shared = shared_.has_value() || out.links.count > 0;
}

void Peer::PublishParked(std::int64_t now_ns) noexcept {
  for (std::size_t b = 0; b < body_count(); ++b) {
    if (!ownership_.Parks(b) || IsLoose(b, now_ns)) {
      next_parked_ns_[b] = 0;
      continue;
    }
    if (ownership_.listening() || now_ns < next_parked_ns_[b]) continue;
    next_parked_ns_[b] = now_ns + kParkedPeriodNs;
    const RigidState& state = world_->state(b);
    const Pose* parked_at = ownership_.ParkedAt(b);
    parked_.TryPush({.peer = options_.id,
                     .object = world_->model().object[b],
                     .epoch = ownership_.epoch(b),
                     .seq = seq_,
                     .flags = kStateParked,
                     .sample_ns = now_ns,
                     .X_WB = parked_at != nullptr ? *parked_at : state.X_WB,
                     .V_WB = state.V_WB,
                     .contact_B_W = {}});
  }
}

}  // namespace tandem
