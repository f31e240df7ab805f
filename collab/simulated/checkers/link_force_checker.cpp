#include "collab/simulated/checkers/link_force_checker.h"

#include <array>

namespace tandem {

void LinkForceChecker::Check(SimulatedSession& session) {
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (!session.present(m) || session.halted(m)) continue;
    Peer& peer = session.node(m).peer();
    if (peer.shared() == nullptr) continue;
    const PeerId self = session.id(m);
    std::array<LinkView, kMaxLinks> views;
    const std::size_t count = peer.shared()->Links(session.network().LocalNow(self), views);
    for (std::size_t o = 0; o < session.size(); ++o) {
      if (o == m || !session.present(o) || session.halted(o)) continue;
      Peer& other = session.node(o).peer();
      if (other.shared() == nullptr) continue;
      for (std::size_t i = 0; i < count; ++i) {
        const double loop_s = views[i].loop_age_s;
        if (views[i].peer != session.id(o) || loop_s <= 0 || loop_s > short_loop_) continue;
        const auto& [X, V] = *peer.held_state();
        const auto& [Y, U] = *other.held_state();
        const Wrench& F = peer.report().links_B_W[i];
        const Vec3 way = Y.p - X.p;
        const Vec3 turn = RotationVector(Y.q * X.q.conjugate());
        Pull& pull = pulls_[{self, session.id(o)}];
        if (way.dot(U.v - V.v) >= 0) {
          pull.together += kFrame * F.f.dot(way);
          pull.all += kFrame * F.f.norm() * way.norm();
        }
        if (turn.norm() > kMostTurn || turn.dot(U.w - V.w) < 0) continue;
        pull.turned += kFrame * F.tau.dot(turn);
        pull.all_turned += kFrame * F.tau.norm() * turn.norm();
      }
    }
  }
}

void LinkForceChecker::CheckEnd() {
  for (const auto& [ends, pull] : pulls_) {
    const std::string to = "to peer " + std::to_string(ends.second);
    if (pull.all > kEnough && pull.together < kLeastTogether * pull.all) {
      violations_->Add("a link pushes instances apart", ends.first,
                       to + Text(", %.4f of %.4f J s", pull.together, pull.all));
    }
    if (pull.all_turned > kEnoughTurned && pull.turned < kLeastTogether * pull.all_turned) {
      violations_->Add("a link turns instances apart", ends.first,
                       to + Text(", %.4f of %.4f J s", pull.turned, pull.all_turned));
    }
  }
}

}  // namespace tandem
