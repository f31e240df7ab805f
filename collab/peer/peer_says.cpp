#include <algorithm>
#include <span>

#include "collab/peer/peer.h"
#include "collab/session/planted_faults.h"

// Output of a peer after a frame: to the other peers, to viewers and to its own program.

namespace tandem {

namespace {

constexpr std::int64_t kParkedPeriodNs = 200'000'000;
constexpr std::int64_t kViewTurnNs = 16'666'667;  // between two pictures, at 60 Hz
constexpr double kFastestShown = 10.0;            // m/s; of a picture

}  // namespace

void Peer::FillOutbox(std::int64_t now_ns, Outbox& out) noexcept {
  out.seq = ++seq_;
  FillView(now_ns, out.view);
  out.holds = held_ >= 0 && !holdings_.listening();
  if (!out.holds) return;
  gate_.NoteSent(now_ns);
  const auto body = static_cast<std::size_t>(held_);
  const RigidState& state = *held_state();
  out.state = {.peer = options_.id,
               .object = world_->model().object[body],
               .epoch = holdings_.own_epoch(body),
               .seq = seq_,
               .flags = report_.flags | AsFlags(limits_.last()),
               .sample_ns = now_ns,
               .X_WB = state.X_WB,
               .V_WB = report_.waited > 0 ? Twist{} : state.V_WB,  // the body stands
               .contact_B_W = report_.contact_B_W};
  if (Planted(Fault::kTurnTooLong)) out.state.X_WB.q.coeffs() *= 1.01;
  if (Planted(Fault::kStampOfBefore) && seq_ % 100 == 0) out.state.sample_ns -= 50'000'000;
  if (Planted(Fault::kBodyForObject)) out.state.object = static_cast<ObjectId>(body);
  out.links.from = options_.id;
  out.links.object = kNoObject;
  out.links.seq = seq_;
  out.links.sample_ns = now_ns;
  out.links.count = 0;
  if (shared_) shared_->Describe(now_ns, seq_, report_, out.links);
  echoes_.Append(now_ns, out.links);
  out.shared = shared_.has_value() || out.links.count > 0;
}

void Peer::FillView(std::int64_t now_ns, ViewFrame& view) const noexcept {
  view.peer = options_.id;
  view.seq = seq_;
  view.sample_ns = now_ns;
  view.delay_ms = static_cast<float>(1e3 * (shared_ ? shared_->delay_s(now_ns) : 0.0));
  view.mirror_lag_mm = static_cast<float>(1e3 * mirror_lag_m());
  view.link_force = 0;
  view.V_W = {};
  view.count = 0;
  const auto add = [&](std::size_t b, std::uint32_t flags, const Vec3& hand_force_W) {
    const Pose X_W = world_->state(b).X_WB * world_->model().bodies[b].X_WB0.Inverse();
    view.bodies[view.count++] = {.object = world_->model().object[b],
                                 .flags = flags,
                                 .X_W = X_W,
                                 .hand_force_W = hand_force_W};
  };
  if (held_ >= 0) {
    std::uint32_t flags = ViewBody::kHeld;
    if (report_.contact_points > 0) flags |= ViewBody::kInContact;
    if (parting_.trapped()) flags |= ViewBody::kTrapped;
    flags |= AsFlags(limits_.last());
    add(static_cast<std::size_t>(held_), flags, report_.hand_B_W.f);
    for (std::size_t link = 0; link < inputs_.link_count; ++link) {
      const auto force = static_cast<float>(report_.links_B_W[link].f.norm());
      view.link_force = std::max(view.link_force, force);
    }
    const auto& [X_WB, V_WB] = *held_state();
    const Vec3 v = V_WB.v + V_WB.w.cross(view.bodies[0].X_W.p - X_WB.p);
    if (v.norm() < kFastestShown) view.V_W = {V_WB.w, v};
  }
  const auto stands = [&](std::size_t b) {
    return static_cast<int>(b) != held_ && holdings_.Parks(b);
  };
  const std::uint32_t in_hand = view.count;
  const std::size_t room = kMaxViewBodies - in_hand;
  std::size_t standing = 0;
  for (std::size_t b = 0; b < inputs_.bodies.size(); ++b) {
    if (stands(b) && standing++ < room) add(b, 0, Vec3::Zero());
  }
  if (standing <= room) return;
  // too many for one frame: each frame sent shows the next part, and viewers put them together
  const std::size_t first = static_cast<std::size_t>(now_ns / kViewTurnNs) * room % standing;
  view.count = in_hand;
  std::size_t number = 0;
  for (std::size_t b = 0; b < inputs_.bodies.size(); ++b) {
    if (stands(b) && (number++ + standing - first) % standing < room) add(b, 0, Vec3::Zero());
  }
}

void Peer::SayParked(std::int64_t now_ns) noexcept {
  if (Planted(Fault::kNoParkedPose)) return;
  for (std::size_t b = 0; b < inputs_.bodies.size(); ++b) {
    if (!holdings_.Parks(b) || IsLoose(b, now_ns)) {
      next_parked_ns_[b] = 0;
      continue;
    }
    if (holdings_.listening() || now_ns < next_parked_ns_[b]) continue;
    next_parked_ns_[b] = now_ns + kParkedPeriodNs;
    const RigidState& state = world_->state(b);
    const Pose* told = holdings_.ParkedAt(b);
    parked_.TryPush({.peer = options_.id,
                     .object = world_->model().object[b],
                     .epoch = holdings_.epoch(b) - (Planted(Fault::kEpochOfBefore) ? 1U : 0U),
                     .seq = seq_,
                     .flags = kStateParked,
                     .sample_ns = now_ns,
                     .X_WB = told != nullptr ? *told : state.X_WB,
                     .V_WB = state.V_WB,
                     .contact_B_W = {}});
  }
}

void Peer::FillTable(std::int64_t now_ns) noexcept {
  PeerTable& table = table_.back();
  table.time_ns = now_ns;
  table.own_limits = limits_.last();
  table.own_layer = inputs_.clearance.force_layer;
  table.own_displacement_m = inputs_.clearance.displacement;
  const std::span<const Echoes::Loop> loops = echoes_.loops();
  table.count = static_cast<std::uint32_t>(loops.size());
  std::array<LinkView, kMaxLinks> links;
  const std::size_t link_count = shared_ ? shared_->Links(now_ns, links) : 0;
  for (std::size_t i = 0; i < table.count; ++i) {
    PeerTableRow& row = table.rows[i];
    row = {};
    row.peer = loops[i].peer;
    row.loop_age_s = loops[i].age_s;
    row.mirror_age_s = loops[i].heard_s;
    for (std::size_t k = 0; k < link_count; ++k) {
      if (links[k].peer != row.peer) continue;
      row.coupled = links[k].closed;
      if (row.coupled) row.loop_age_s = links[k].loop_age_s;
      row.stiffness = links[k].stiffness;
      row.link_force = links[k].force;
      row.its_link_force = links[k].its_force;
      row.disagreement = links[k].disagreement;
      row.trapped = parting_.trapped(row.peer);
    }
    const auto* limits = std::ranges::find(heard_limits_, row.peer, &HeardLimits::peer);
    if (limits != heard_limits_.end()) row.limits = LimitsIn(limits->flags);
    row.delay_s = 0.5 * row.loop_age_s;
    row.mirror_lag_m = remote_.LagOf(row.peer);
    row.drops = inbox_->drops().Of(row.peer);
  }
  table_.Publish();
}

}  // namespace tandem
