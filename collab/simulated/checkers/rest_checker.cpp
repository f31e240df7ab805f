#include "collab/simulated/checkers/rest_checker.h"

#include <algorithm>
#include <cmath>

namespace tandem {

void RestChecker::Check(SimulatedSession& session, const std::vector<int>& member,
                        const HandChecker& hands, const Viewer& viewer) {
  std::vector<std::size_t> present;
  // a contact on one instance of a body loads the hands on all instances
  const std::size_t bodies = session.node(0).world().model().bodies.size();
  std::vector<double> contacts(bodies, 0.0);
  for (std::size_t m = 0; m < session.size(); ++m) {
    const Peer& peer = session.node(m).peer();
    const int held = session.present(m) ? peer.ownership().held() : -1;
    if (held < 0) continue;
    contacts[static_cast<std::size_t>(held)] += peer.report().contact_B_W.f.norm();
  }
  for (std::size_t p = 0; p < member.size(); ++p) {
    if (member[p] < 0 || !session.present(static_cast<std::size_t>(member[p]))) continue;
    const auto m = static_cast<std::size_t>(member[p]);
    present.push_back(m);
    // a contact may push for ever
    const double force = hands.given(p).f.norm();
    const int held = session.node(m).peer().ownership().held();
    const double contact = held < 0 ? 0 : contacts[static_cast<std::size_t>(held)];
    if (force > kMostForce + contact) {
      violations_->Add("a hand is pulled though all is quiet", session.id(m),
                       Text("%.2f N", force));
    }
  }
  CheckMembership(session, present, viewer);
  CheckCopies(session, present);
}

void RestChecker::CheckMembership(SimulatedSession& session,
                                  const std::vector<std::size_t>& present, const Viewer& viewer) {
  const ViewerPicture picture = viewer.Picture();
  for (const std::size_t m : present) {
    const PeerId id = session.id(m);
    std::size_t here = 0;
    for (const PeerDirectory::Entry& entry : session.node(m).directory().Entries()) {
      if (entry.presence != PeerDirectory::Presence::kHere || entry.info.role != Role::kActive) {
        continue;
      }
      ++here;
      const bool is_present = std::any_of(present.begin(), present.end(), [&](std::size_t other) {
        return session.id(other) == entry.info.peer;
      });
      if (!is_present) violations_->Add("one who is gone is still here", id);
    }
    if (here + 1 < present.size()) violations_->Add("one who is here is missed", id);
    const bool seen =
        std::any_of(picture.peers.begin(), picture.peers.end(), [&](const ViewedPeer& peer) {
          return peer.info.peer == id && peer.presence == ViewedPeer::Presence::kHere;
        });
    if (!seen) violations_->Add("the viewer misses one", id);
  }
}

void RestChecker::CheckCopies(SimulatedSession& session, const std::vector<std::size_t>& present) {
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    // a body that is pressed against another gives way at each peer separately
    const bool pressed = std::any_of(present.begin(), present.end(), [&](std::size_t m) {
      return session.node(m).world().Pushed(b);
    });
    if (pressed) continue;
    for (const std::size_t i : present) {
      for (const std::size_t j : present) {
        const Pose& X = session.node(i).world().state(b).X_WB;
        const Pose& Y = session.node(j).world().state(b).X_WB;
        const double distance = (X.p - Y.p).norm();
        const double angle = X.q.angularDistance(Y.q);
        if (distance <= kDistance && angle <= kAngle) continue;
        violations_->Add(
            "copies of " + model_->bodies[b].name + " disagree", session.id(i),
            "and peer " + std::to_string(session.id(j)) +
                Text(", by %.2f mm, %.2f degrees", 1e3 * distance, angle * 180.0 / M_PI));
      }
    }
  }
}

void RestChecker::CheckLinks(SimulatedSession& session, WireChecker& wire) {
  std::vector<std::size_t> holders;
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (session.present(m) && session.node(m).peer().shared() != nullptr) holders.push_back(m);
  }
  for (const std::size_t m : holders) CheckLinksOf(session, m, holders, wire);
}

void RestChecker::CheckLinksOf(SimulatedSession& session, std::size_t member,
                               const std::vector<std::size_t>& holders, WireChecker& wire) {
  const PeerId id = session.id(member);
  // loop ages go to all peers, links to holders
  CouplingLinks links = wire.NewestLinks(id);
  const auto* const end = std::remove_if(
      links.entries.begin(), links.entries.begin() + links.count, [&](const LinkEntry& entry) {
        return std::none_of(holders.begin(), holders.end(), [&](std::size_t other) {
          return session.id(other) == entry.to;
        });
      });
  links.count = static_cast<std::uint32_t>(end - links.entries.begin());
  if (links.count + 1 != holders.size()) {
    violations_->Add("a link is missing, or one too many", id,
                     Text("%u in place of %zu", links.count, holders.size() - 1));
    return;
  }
  const std::size_t self = wire.PlaceOf(id);
  double worst_s = 0;
  for (const std::size_t other : holders) {
    if (other == member) continue;
    worst_s = std::max(worst_s, wire.LongestLoop(self, wire.PlaceOf(session.id(other))));
  }
  const double users = std::max(1.0, static_cast<double>(links.count));
  // samples are up to 10 ms apart at either end, and wait for a frame
  const double least = 0.95 * LargestStiffness(schedule_->law, worst_s + 0.05) / users;
  for (std::uint32_t i = 0; i < links.count; ++i) {
    const std::size_t o = wire.PlaceOf(links.entries[i].to);
    const double loop_s = 1e-3 * (schedule_->delay_ms[self][o] + schedule_->delay_ms[o][self]);
    const double k = links.entries[i].stiffness;
    if (k > 1.001 * LargestStiffness(schedule_->law, loop_s) / users) {
      violations_->Add("a link too stiff for the users", id, Text("%.1f N/m", k));
    }
    if (k < least) {
      violations_->Add("a link softer than the law", id,
                       Text("%.1f N/m in place of %.1f", k, least));
    }
  }
}

}  // namespace tandem
