#include "collab/peer/peer_telemetry.h"

#include <algorithm>
#include <array>

namespace tandem {

namespace {

constexpr std::int64_t kViewTurnNs = 16'666'667;  // between two pictures, at 60 Hz
constexpr double kFastestShown = 10.0;            // m/s; of a picture

}  // namespace

PeerTelemetry::PeerTelemetry(const Parts& parts, std::size_t trace_frames) : parts_(parts) {
  trace_.resize(trace_frames);
}

PeerTelemetry::FrameEvents PeerTelemetry::CountStep() noexcept {
  const StepReport& report = parts_.report;
  limits_.Count(report.flags);
  FrameEvents events{.voxels_came = report.waited == 0 && waited_ > 0};
  waited_ = report.waited;
  if (waited_ > 0) {
    voxel_waits_.count += waited_ == 1 ? 1 : 0;
    ++voxel_waits_.frames;
    voxel_waits_.longest = std::max(voxel_waits_.longest, waited_);
    if (waited_ >= kLongestVoxelWait) voxels_missing_.store(true, std::memory_order_relaxed);
  }
  if ((report.flags & StepReport::kContactsFull) != 0) {
    events.first_crowded = crowded_frames_ == 0;
    ++crowded_frames_;
  }
  return events;
}

void PeerTelemetry::CountForce(const Wrench& given) noexcept {
  rendered_.peak_force = std::max(rendered_.peak_force, given.f.norm());
  rendered_.peak_moment = std::max(rendered_.peak_moment, given.tau.norm());
  rendered_.peak_step = std::max(rendered_.peak_step, (given.f - rendered_.F_D_W.f).norm());
  rendered_.F_D_W = given;
}

void PeerTelemetry::NoteLimits(const ObjectState& state) noexcept {
  if (state.peer == 0) return;  // no peer has this number
  ReceivedLimits* received = received_limits_.FindOrInsert(state.peer);
  if (received == nullptr) {  // the limits heard first give way
    received = received_limits_.InSlot(next_received_);
    next_received_ = (next_received_ + 1) % received_limits_.capacity();
    received_limits_.Erase(received->peer);
    received = received_limits_.FindOrInsert(state.peer);
  }
  received->flags = state.flags;
}

void PeerTelemetry::RecordHand(std::int64_t now_ns, int body) noexcept {
  const StepReport& report = parts_.report;
  const double force = report.hand_B_W.f.norm();
  ++hand_figures_.frames;
  hand_figures_.frames_in_contact += report.contact_points > 0 ? 1 : 0;
  hand_figures_.contact_points += report.contact_points;
  hand_figures_.most_contact_points =
      std::max(hand_figures_.most_contact_points, report.contact_points);
  hand_figures_.peak_force = std::max(hand_figures_.peak_force, force);
  hand_limits_.Count(report.flags);
  hand_figures_.limits = hand_limits_.all();
  const std::size_t frame = traced_.load(std::memory_order_relaxed);
  if (frame >= trace_.size()) return;
  const RigidState& state = parts_.world.state(static_cast<std::size_t>(body));
  trace_[frame] = {.time_ns = now_ns,
                   .X_WB = state.X_WB,
                   .V_WB = state.V_WB,
                   .hand_force = static_cast<float>(force),
                   .contact_points = report.contact_points,
                   .pushing = report.pushing_points > 0};
  traced_.store(frame + 1, std::memory_order_release);
}

void PeerTelemetry::AddBody(std::size_t body, std::uint32_t flags, const Vec3& hand_force_W,
                            ViewFrame& view) const noexcept {
  const WorldModel& model = parts_.world.model();
  view.bodies[view.count++] = {
      .object = model.object[body],
      .flags = flags,
      .X_W = parts_.world.state(body).X_WB * model.bodies[body].X_WB0.Inverse(),
      .hand_force_W = hand_force_W};
}

void PeerTelemetry::FillView(std::int64_t now_ns, std::uint32_t seq, const InHand& hand,
                             ViewFrame& view) const noexcept {
  const StepReport& report = parts_.report;
  view.peer = parts_.id;
  view.seq = seq;
  view.sample_ns = now_ns;
  view.delay_ms = static_cast<float>(1e3 * (hand.shared ? hand.shared->delay_s(now_ns) : 0.0));
  view.mirror_lag_mm = static_cast<float>(1e3 * parts_.remote.mirror_lag_m());
  view.link_force = 0;
  view.V_W = {};
  view.count = 0;
  if (hand.body >= 0) {
    std::uint32_t flags = ViewBody::kHeld;
    if (report.contact_points > 0) flags |= ViewBody::kInContact;
    if (parts_.separation.trapped()) flags |= ViewBody::kTrapped;
    flags |= limit_flags();
    AddBody(static_cast<std::size_t>(hand.body), flags, report.hand_B_W.f, view);
    for (std::size_t link = 0; link < parts_.inputs.link_count; ++link) {
      const auto force = static_cast<float>(report.links_B_W[link].f.norm());
      view.link_force = std::max(view.link_force, force);
    }
    const auto& [X_WB, V_WB] = parts_.world.state(static_cast<std::size_t>(hand.body));
    const Vec3 v = V_WB.v + V_WB.w.cross(view.bodies[0].X_W.p - X_WB.p);
    if (v.norm() < kFastestShown) view.V_W = {V_WB.w, v};
  }
  AddStanding(now_ns, hand.body, view);
}

void PeerTelemetry::AddStanding(std::int64_t now_ns, int held, ViewFrame& view) const noexcept {
  const auto stands = [&](std::size_t b) {
    return static_cast<int>(b) != held && parts_.ownership.Parks(b);
  };
  const std::size_t bodies = parts_.world.model().bodies.size();
  const std::uint32_t in_hand = view.count;
  const std::size_t room = kMaxViewBodies - in_hand;
  std::size_t standing = 0;
  for (std::size_t b = 0; b < bodies; ++b) {
    if (stands(b) && standing++ < room) AddBody(b, 0, Vec3::Zero(), view);
  }
  if (standing <= room) return;
  // too many for one frame: each frame sent shows the next part, and viewers put them together
  const std::size_t first = static_cast<std::size_t>(now_ns / kViewTurnNs) * room % standing;
  view.count = in_hand;
  std::size_t number = 0;
  for (std::size_t b = 0; b < bodies; ++b) {
    if (stands(b) && (number++ + standing - first) % standing < room) {
      AddBody(b, 0, Vec3::Zero(), view);
    }
  }
}

void PeerTelemetry::PublishTable(std::int64_t now_ns, const SharedBody* shared) noexcept {
  PeerTable& table = table_.back();
  table.time_ns = now_ns;
  table.own_limits = limits_.last();
  table.own_layer = parts_.inputs.clearance.force_layer;
  table.own_displacement_m = parts_.inputs.clearance.displacement;
  table.own_stopped = parts_.ownership.stopped();
  const std::span<const RoundTripTracker::Loop> loops = parts_.round_trips.loops();
  table.count = static_cast<std::uint32_t>(loops.size());
  std::array<LinkView, kMaxLinks> links;
  const std::size_t link_count = shared != nullptr ? shared->Links(now_ns, links) : 0;
  for (std::size_t i = 0; i < table.count; ++i) {
    FillRow(loops[i], {links.data(), link_count}, table.rows[i]);
  }
  table_.Publish();
}

void PeerTelemetry::FillRow(const RoundTripTracker::Loop& loop, std::span<const LinkView> links,
                            PeerTableRow& row) const noexcept {
  row = {};
  row.peer = loop.peer;
  row.loop_age_s = loop.age_s;
  row.mirror_age_s = loop.received_s;
  for (const LinkView& link : links) {
    if (link.peer != row.peer) continue;
    row.coupled = link.closed;
    if (row.coupled) row.loop_age_s = link.loop_age_s;
    row.stiffness = link.stiffness;
    row.link_force = link.force;
    row.its_link_force = link.its_force;
    row.disagreement = link.disagreement;
    row.trapped = parts_.separation.trapped(row.peer);
  }
  const ReceivedLimits* const limits = received_limits_.Find(row.peer);
  if (limits != nullptr) row.limits = LimitsIn(limits->flags);
  row.delay_s = 0.5 * row.loop_age_s;
  row.mirror_lag_m = parts_.remote.LagOf(row.peer);
  row.drops = parts_.drops.CountsOf(row.peer);
}

}  // namespace tandem
