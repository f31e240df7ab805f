#include "collab/simulated/session_checker.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tandem {

namespace {

bool IsFinite(const Pose& X) {
  return X.p.allFinite() && X.q.coeffs().allFinite();
}

bool IsFinite(const Wrench& F) {
  return F.tau.allFinite() && F.f.allFinite();
}

std::string Text(const char* format, double a, double b = 0) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

SessionChecker::SessionChecker(const FaultSchedule& schedule, const WorldModel& model,
                               PeerId viewer)
    : schedule_(&schedule),
      model_(&model),
      viewer_(viewer),
      least_delay_ms_(schedule.peers.size(), std::vector<double>(schedule.peers.size(), 1e9)),
      most_delay_ms_(schedule.peers.size(), std::vector<double>(schedule.peers.size(), 0.0)),
      force_(schedule.peers.size(), Vec3::Zero()) {}

void SessionChecker::Break(const std::string& sort, const std::string& what) {
  if (sorts_[sort]++ > 0) return;
  broken_.push_back(Text("at %.3f s: ", 1e-9 * static_cast<double>(now_ns_)) + sort + ": " + what);
}

std::size_t SessionChecker::PlaceOf(PeerId id) const {
  const auto it = std::find_if(schedule_->peers.begin(), schedule_->peers.end(),
                               [id](const ScheduledPeer& peer) {
                                 return peer.id == id;
                               });
  return static_cast<std::size_t>(it - schedule_->peers.begin());
}

void SessionChecker::LinkSwitched(std::size_t from, std::size_t to, const LinkConditions& link) {
  double& least = least_delay_ms_[from][to];
  least = std::min(least, std::max(0.0, link.delay_ms - link.swing_ms));
  double& most = most_delay_ms_[from][to];
  most = std::max(most, link.delay_ms + link.swing_ms + link.jitter_ms);
}

double SessionChecker::LargestStiffness(double loop_s) {
  // p+d as docs/decisions/0005 derives it: B = 10 N s/m, K0 = 500 N/m, margin 0.8, 1.5 kg
  if (loop_s > 2.4) return 0.0;
  const double te = 0.5 * (1.1 * loop_s + 0.005);
  return 0.8 * std::min(500.0, 10.0 / te + 100.0 / (3.0 * 1.5));
}

void SessionChecker::OnState(PeerId from, const ObjectState& state) {
  const std::string who = "peer " + std::to_string(from);
  if (from == viewer_) Break("a viewer writes", who);
  if (state.peer != from) Break("a peer writes as another", who);
  if (!IsFinite(state.X_WB) || !state.V_WB.v.allFinite() || !state.V_WB.w.allFinite() ||
      !IsFinite(state.contact_B_W)) {
    Break("not finite on the wire", who);
  }
  if (std::abs(state.X_WB.q.norm() - 1.0) > 1e-6) Break("a rotation that is none", who);
  Writer& writer = writers_[from];
  const bool fresh = writer.stamps.empty() || writer.stamps.back() < state.sample_ns;
  if (fresh) {
    writer.stamps.push_back(state.sample_ns);
  } else if (writer.stamps.back() > state.sample_ns) {
    Break("stamps go back", who);
  }
  std::uint32_t& epoch = writer.epoch[state.object];
  if (state.epoch < epoch) Break("an epoch goes back", who);
  epoch = state.epoch;
}

void SessionChecker::OnLinks(PeerId from, const CouplingLinks& links) {
  const std::string who = "peer " + std::to_string(from);
  if (from == viewer_) Break("a viewer writes", who);
  if (links.from != from) Break("a peer writes as another", who);
  Writer& writer = writers_[from];
  if (writer.stamps.empty() || writer.stamps.back() < links.sample_ns) {
    writer.stamps.push_back(links.sample_ns);
  }
  const std::size_t self = PlaceOf(from);
  for (std::uint32_t i = 0; i < links.count; ++i) {
    const LinkEntry& entry = links.entries[i];
    if (!IsFinite(entry.applied_B_W) || !std::isfinite(entry.stiffness)) {
      Break("not finite on the wire", who);
    }
    if (entry.stiffness < 0) Break("a stiffness below zero", who);
    const std::vector<std::int64_t>& its = writers_[entry.to].stamps;
    if (entry.echo_ns != 0 && !std::binary_search(its.begin(), its.end(), entry.echo_ns)) {
      Break("an echo that was never sent", who);
    }
    const std::size_t other = PlaceOf(entry.to);
    if (self >= least_delay_ms_.size() || other >= least_delay_ms_.size()) {
      Break("a link to nobody", who);
      continue;
    }
    // no loop is shorter than its links
    const double loop_s = 1e-3 * (least_delay_ms_[self][other] + least_delay_ms_[other][self]);
    const double most = LargestStiffness(loop_s);
    if (entry.stiffness > 1.001 * most && links.object != kNoObject) {
      Break("a link stiffer than its loop allows",
            who + Text(", %.1f N/m in place of %.1f", entry.stiffness, most));
    }
  }
  writer.links = links;
}

void SessionChecker::OnView(PeerId from, const ViewFrame& view) {
  const std::string who = "peer " + std::to_string(from);
  if (from == viewer_) Break("a viewer writes", who);
  if (view.peer != from) Break("a peer writes as another", who);
}

void SessionChecker::Felt(std::size_t peer, const Vec3& force) {
  const std::string who = "peer " + std::to_string(schedule_->peers[peer].id);
  if (!force.allFinite()) {
    Break("a hand's force is not finite", who);
    return;
  }
  if (force.norm() > kMostForce + 1e-9) {
    Break("a hand's force is beyond the clamp", who + Text(", %.2f N", force.norm()));
  }
  const double step = (force - force_[peer]).norm();
  if (step > kMostForceStep + 1e-9) {
    Break("a hand's force jumps", who + Text(", %.2f N in a frame", step));
  }
  force_[peer] = force;
}

void SessionChecker::Look(SimulatedSession& session) {
  now_ns_ = session.now_ns();
  place_.resize(session.size());
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (!session.present(m) || session.halted(m)) continue;
    LookAtEnergy(session, m);
    const World& world = session.node(m).world();
    const bool first = place_[m].empty();
    place_[m].resize(model_->bodies.size());
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      const RigidState& state = world.state(b);
      const std::string who = "peer " + std::to_string(session.id(m));
      if (!IsFinite(state.X_WB) || !state.V_WB.v.allFinite() || !state.V_WB.w.allFinite()) {
        Break("a simulation is not finite", who);
        continue;
      }
      // mirrors may come a long way at once where nothing is near
      const bool held = session.node(m).peer().held_state() == &state;
      const double moved = (state.X_WB.p - place_[m][b]).norm();
      if (held && !first && moved > model_->scene.voxel_size) {
        Break("a body in hand jumps", who + Text(", by %.2f mm", 1e3 * moved));
      }
      place_[m][b] = state.X_WB.p;
    }
  }
}

void SessionChecker::LookAtEnergy(SimulatedSession& session, std::size_t member) {
  PeerNode& node = session.node(member);
  const RigidState* held = node.peer().held_state();
  if (held == nullptr) return;
  constexpr double kMostDrag = 10.0;         // N s/m, as docs/decisions/0005 allows
  constexpr double kGyration2 = 0.0004 / 6;  // m^2, of a cube of 20 mm half edges
  double power = 0;
  for (const Wrench& F : node.peer().report().links_B_W) {
    power += F.f.dot(held->V_WB.v) + F.tau.dot(held->V_WB.w);
  }
  const double drag =
      kMostDrag * (held->V_WB.v.squaredNorm() + 4.0 * kGyration2 * held->V_WB.w.squaredNorm());
  energy_ += kFrame * (power - (power != 0 ? drag : 0.0));
  const double n = static_cast<double>(schedule_->peers.size());
  const double credit = 0.1 * n * (n - 1) * 2.0;
  if (energy_ > credit) Break("links give more energy than their credit", Text("%.3f J", energy_));
}

void SessionChecker::LookAtEnd(SimulatedSession& session, const std::vector<int>& of_peer,
                               const Viewer& viewer) {
  now_ns_ = session.now_ns();
  std::vector<std::size_t> present;
  for (const int member : of_peer) {
    if (member >= 0 && session.present(static_cast<std::size_t>(member))) {
      present.push_back(static_cast<std::size_t>(member));
    }
  }
  for (const std::size_t member : present) {
    const std::string who = "peer " + std::to_string(session.id(member));
    std::size_t here = 0;
    for (const PeerDirectory::Entry& entry : session.node(member).directory().Entries()) {
      if (entry.presence != PeerDirectory::Presence::kHere || entry.info.role != Role::kActive) {
        continue;
      }
      ++here;
      const auto is_it = [&](std::size_t m) {
        return session.id(m) == entry.info.peer;
      };
      if (std::none_of(present.begin(), present.end(), is_it)) {
        Break("one who is gone is still here", who);
      }
    }
    if (here + 1 < present.size()) Break("one who is here is missed", who);
    const ViewerPicture picture = viewer.Picture();
    const auto seen =
        std::find_if(picture.peers.begin(), picture.peers.end(), [&](const ViewedPeer& peer) {
          return peer.info.peer == session.id(member);
        });
    if (seen == picture.peers.end() || seen->presence != ViewedPeer::Presence::kHere) {
      Break("the viewer misses one", who);
    }
  }
  for (std::size_t p = 0; p < of_peer.size(); ++p) {
    const bool here = of_peer[p] >= 0 && session.present(static_cast<std::size_t>(of_peer[p]));
    // all hands rest at one place, where nothing touches
    if (here && force_[p].norm() > kMostForceAtRest) {
      Break("a hand is pulled though all is quiet",
            "peer " + std::to_string(schedule_->peers[p].id) + Text(", %.2f N", force_[p].norm()));
    }
  }
  LookAtCopies(session, present);
}

void SessionChecker::LookAtCopies(SimulatedSession& session,
                                  const std::vector<std::size_t>& present) {
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    const bool in_hand = std::any_of(present.begin(), present.end(), [&](std::size_t member) {
      PeerNode& node = session.node(member);
      return node.peer().held_state() == &node.world().state(b);
    });
    if (!in_hand) continue;
    for (const std::size_t i : present) {
      for (const std::size_t j : present) {
        const Pose& X = session.node(i).world().state(b).X_WB;
        const Pose& Y = session.node(j).world().state(b).X_WB;
        const double distance = (X.p - Y.p).norm();
        const double angle = X.q.angularDistance(Y.q);
        if (distance <= kAgreeDistance && angle <= kAgreeAngle) continue;
        Break("copies of " + model_->bodies[b].name + " disagree",
              "peers " + std::to_string(session.id(i)) + " and " + std::to_string(session.id(j)) +
                  Text(", %.2f mm, %.2f degrees", 1e3 * distance, angle * 180.0 / M_PI));
      }
    }
  }
}

void SessionChecker::LookAtLinks(SimulatedSession& session) {
  now_ns_ = session.now_ns();
  // those who hold the shared body: each must be linked to each, as stiff as the law says
  std::vector<std::size_t> holders;
  for (std::size_t member = 0; member < session.size(); ++member) {
    if (!session.present(member)) continue;
    PeerNode& node = session.node(member);
    const RigidState* held = node.peer().held_state();
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      const bool shared = model_->scene.bodies[model_->object[b]].shared;
      if (held == &node.world().state(b) && shared) holders.push_back(member);
    }
  }
  for (const std::size_t member : holders) {
    const PeerId id = session.id(member);
    const std::string who = "peer " + std::to_string(id);
    // loop ages go to all, links to holders
    CouplingLinks links = writers_[id].links;
    const auto* const end = std::remove_if(
        links.entries.begin(), links.entries.begin() + links.count, [&](const LinkEntry& entry) {
          return std::none_of(holders.begin(), holders.end(), [&](std::size_t other) {
            return session.id(other) == entry.to;
          });
        });
    links.count = static_cast<std::uint32_t>(end - links.entries.begin());
    if (links.count + 1 != holders.size()) {
      Break("a link is missing, or one too many",
            who + Text(", %.0f in place of %.0f", links.count,
                       static_cast<double>(holders.size()) - 1));
      continue;
    }
    const std::size_t self = PlaceOf(id);
    double worst_s = 0;
    for (const std::size_t other : holders) {
      if (other == member) continue;
      const std::size_t o = PlaceOf(session.id(other));
      worst_s = std::max(worst_s, 1e-3 * (most_delay_ms_[self][o] + most_delay_ms_[o][self]));
    }
    double users = 0;  // links of loops too old are not in use
    for (std::uint32_t i = 0; i < links.count; ++i) users += links.entries[i].stiffness > 0 ? 1 : 0;
    users = std::max(users, 1.0);
    for (std::uint32_t i = 0; i < links.count; ++i) {
      const std::size_t o = PlaceOf(links.entries[i].to);
      const double loop_s = 1e-3 * (schedule_->delay_ms[self][o] + schedule_->delay_ms[o][self]);
      // samples are up to 10 ms apart at either end, and wait for a frame
      const double k = links.entries[i].stiffness;
      if (k > 1.001 * LargestStiffness(loop_s) / users) {
        Break("a link too stiff for the users", who + Text(", %.1f N/m", k));
      }
      if (k < 0.95 * LargestStiffness(worst_s + 0.05) / users) {
        Break("a link softer than the law",
              who + Text(", %.1f N/m in place of %.1f", k, LargestStiffness(worst_s) / users));
      }
    }
  }
}

}  // namespace tandem
