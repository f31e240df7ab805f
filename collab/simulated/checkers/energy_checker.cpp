#include "collab/simulated/checkers/energy_checker.h"

#include <algorithm>
#include <array>

namespace tandem {

void EnergyChecker::Check(SimulatedSession& session) {
  coupled_peers_.resize(session.size());
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (session.present(m) && !session.halted(m)) CheckMember(session, m);
  }
}

void EnergyChecker::CheckMember(SimulatedSession& session, std::size_t member) {
  Peer& peer = session.node(member).peer();
  const PeerId self = session.id(member);
  const SharedBody* const shared = peer.shared();
  std::array<LinkView, kMaxLinks> views;
  const std::size_t count =
      shared == nullptr ? 0 : shared->Links(session.network().LocalNow(self), views);
  std::vector<PeerId> peers;
  double stiffness = 0;
  for (std::size_t i = 0; i < count; ++i) {
    peers.push_back(views[i].peer);
    stiffness += views[i].stiffness;
    const auto& old = coupled_peers_[member];
    if (std::find(old.begin(), old.end(), views[i].peer) != old.end()) continue;
    links_[std::minmax(self, views[i].peer)].credit += kCredit;
  }
  coupled_peers_[member] = std::move(peers);
  if (count == 0) return;

  const auto body = static_cast<std::size_t>(peer.ownership().held());
  const RigidState& own = *peer.held_state();
  const Inertia& inertia = model_->bodies[body].inertia;
  const Mat3 R = own.X_WB.q.toRotationMatrix();
  const Mat3 per_mass = R * inertia.I_B * R.transpose() / inertia.mass;
  const Vec3& v = own.V_WB.v;
  const Vec3& w = own.V_WB.w;
  const double drag = shared->ground_damping() * (v.squaredNorm() + w.dot(per_mass * w));
  for (std::size_t i = 0; i < count; ++i) {
    Link& link = links_[std::minmax(self, views[i].peer)];
    const Wrench& F = peer.report().links_B_W[i];
    const double share = stiffness > 0 ? views[i].stiffness / stiffness : 0.0;
    link.made += kFrame * (F.f.dot(v) + F.tau.dot(w) - 0.9 * drag * share);
    // energy that drag took beyond what tanks and springs can keep is no credit for later
    link.made = std::max(link.made, link.credit - kept_);
    if (link.made <= link.credit + kTolerance) continue;
    violations_->Add("a link gives more energy than its credit", self,
                     "to peer " + std::to_string(views[i].peer) +
                         Text(", %.3f J in place of %.3f", link.made, link.credit));
  }
}

}  // namespace tandem
