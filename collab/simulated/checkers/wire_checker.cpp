#include "collab/simulated/checkers/wire_checker.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

bool IsFinite(const Wrench& F) {
  return F.tau.allFinite() && F.f.allFinite();
}

bool IsFinite(const ObjectState& state) {
  return state.X_WB.p.allFinite() && state.X_WB.q.coeffs().allFinite() &&
         state.V_WB.v.allFinite() && state.V_WB.w.allFinite() && IsFinite(state.contact_B_W);
}

}  // namespace

double LargestStiffness(const std::string& law, double loop_s) {
  if (law == "constant") return 2000.0;
  if (law == "linear") return 40.0 * std::max(0.02, 1.0 - 0.5 * loop_s);
  // B = 10 N s/m, K0 = 500 N/m, margin 0.8, at most 1.5 kg
  const double te = 0.5 * (1.1 * loop_s + 0.005);
  if (law == "pdopt") return 0.8 * std::min(500.0, 1.5 * 10.0 / te);
  const double floating = 10.0 / te + 100.0 / (3.0 * 1.5);
  if (law == "p+dd") return std::min({500.0, 42.0 / te, 1.2 * floating});
  return 0.8 * std::min(500.0, floating);
}

WireChecker::WireChecker(const FaultSchedule& schedule, PeerId viewer, Violations& violations)
    : schedule_(&schedule),
      viewer_(viewer),
      violations_(&violations),
      least_delay_ms_(schedule.peers.size(), std::vector<double>(schedule.peers.size(), 1e9)),
      most_delay_ms_(schedule.peers.size(), std::vector<double>(schedule.peers.size(), 0.0)) {}

std::size_t WireChecker::PlaceOf(PeerId id) const {
  const auto it = std::find_if(schedule_->peers.begin(), schedule_->peers.end(),
                               [id](const ScheduledPeer& peer) {
                                 return peer.id == id;
                               });
  return static_cast<std::size_t>(it - schedule_->peers.begin());
}

void WireChecker::LinkSwitched(std::size_t from, std::size_t to, const LinkConditions& link) {
  double& least = least_delay_ms_[from][to];
  least = std::min(least, std::max(0.0, link.delay_ms - link.swing_ms));
  double& most = most_delay_ms_[from][to];
  most = std::max(most, link.delay_ms + link.swing_ms + link.jitter_ms);
}

void WireChecker::ClockStepped(std::size_t peer, double step_ms) {
  for (auto& row : least_delay_ms_) row[peer] = std::max(0.0, row[peer] - step_ms);
}

double WireChecker::LongestLoop(std::size_t a, std::size_t b) const {
  return 1e-3 * (most_delay_ms_[a][b] + most_delay_ms_[b][a]);
}

void WireChecker::Own(PeerId from, PeerId says) {
  if (from == viewer_) violations_->Add("a viewer writes", from);
  if (says != from) violations_->Add("a peer writes as another", from);
}

void WireChecker::OnState(PeerId from, const ObjectState& state) {
  Own(from, state.peer);
  if (!IsFinite(state)) violations_->Add("not finite on the wire", from);
  if (std::abs(state.X_WB.q.norm() - 1.0) > 1e-6) {
    violations_->Add("a rotation that is none", from);
  }
  Writer& writer = writers_[from];
  const bool fresh = writer.stamps.empty() || writer.stamps.back() < state.sample_ns;
  if (fresh) {
    writer.stamps.push_back(state.sample_ns);
  } else if (writer.stamps.back() > state.sample_ns) {
    violations_->Add("stamps go back", from);
  }
  std::uint32_t& epoch = writer.epoch[state.object];
  if (state.epoch < epoch) violations_->Add("an epoch goes back", from);
  epoch = state.epoch;
}

void WireChecker::OnLinks(PeerId from, const CouplingLinks& links) {
  Own(from, links.from);
  Writer& writer = writers_[from];
  if (writer.stamps.empty() || writer.stamps.back() < links.sample_ns) {
    writer.stamps.push_back(links.sample_ns);
  }
  const std::size_t self = PlaceOf(from);
  for (std::uint32_t i = 0; i < links.count; ++i) {
    const LinkEntry& entry = links.entries[i];
    if (entry.to == hostile_ && hostile_ != 0) continue;
    if (!IsFinite(entry.applied_B_W) || !std::isfinite(entry.stiffness) ||
        !std::isfinite(entry.gate_overflow)) {
      violations_->Add("not finite on the wire", from);
    }
    if (entry.stiffness < 0) violations_->Add("a stiffness below zero", from);
    const std::vector<std::int64_t>& its = writers_[entry.to].stamps;
    if (entry.echo_ns != 0 && !std::binary_search(its.begin(), its.end(), entry.echo_ns)) {
      violations_->Add("an echo that was never sent", from);
    }
    const std::size_t other = PlaceOf(entry.to);
    if (self >= least_delay_ms_.size() || other >= least_delay_ms_.size() || self == other) {
      violations_->Add("a link to nobody", from);
      continue;
    }
    // no loop is shorter than its links
    const double loop_s = 1e-3 * (least_delay_ms_[self][other] + least_delay_ms_[other][self]);
    const double most = LargestStiffness(schedule_->law, loop_s);
    if (entry.stiffness > 1.001 * most && links.object != kNoObject) {
      violations_->Add("a link stiffer than its loop allows", from,
                       Text("%.1f N/m in place of %.1f", entry.stiffness, most));
    }
  }
  writer.links = links;
}

void WireChecker::OnView(PeerId from, const ViewFrame& view) {
  Own(from, view.peer);
}

void WireChecker::OnPeerInfo(PeerId from, const PeerInfo& info) {
  Own(from, info.peer);
  std::uint32_t& beat = writers_[from].beat;
  if (info.beat <= beat) violations_->Add("a beat goes back", from);
  beat = info.beat;
}

void WireChecker::OnEvent(PeerId from, const Event& event) {
  Own(from, event.peer);
  if (!event.X_WB.p.allFinite()) violations_->Add("not finite on the wire", from);
  std::uint32_t& seq = writers_[from].event_seq;
  if (event.seq <= seq) violations_->Add("an event's number goes back", from);
  seq = event.seq;
}

}  // namespace tandem
