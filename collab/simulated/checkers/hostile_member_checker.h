#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "collab/simulated/checkers/violations.h"
#include "collab/simulated/network/simulated_session.h"

namespace tandem {

/// Judges a session with a hostile member. No hand loses a body to it, it grants no body to an
/// honest peer, and no epoch runs away.
class HostileMemberChecker {
 public:
  /// Above all epochs that honest grabs and a hostile member's allowed raises reach in a session.
  static constexpr std::uint32_t kMostEpoch = 200'000;

  HostileMemberChecker(const WorldModel& model, Violations& violations)
      : model_(&model), violations_(&violations) {}

  void SetHostile(PeerId peer) { hostile_ = peer; }
  /// Notes a user's wish, by which the user may lose the body in hand.
  void Wished(PeerId peer, std::int64_t now_ns) { wished_ns_[peer] = now_ns; }

  /// Judges a frame; call it after every frame.
  void Check(SimulatedSession& session) {
    if (hostile_ == 0) return;
    held_.resize(session.size(), -1);
    for (std::size_t m = 0; m < session.size(); ++m) {
      if (!session.present(m) || session.halted(m)) {
        held_[m] = -1;
        continue;
      }
      const Ownership& ownership = session.node(m).peer().ownership();
      for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
        if (ownership.epoch(b) <= kMostEpoch) continue;
        violations_->Add("an epoch runs away", session.id(m), model_->bodies[b].name);
      }
      const int before = std::exchange(held_[m], ownership.held());
      if (before < 0 || before == ownership.held()) continue;
      const auto body = static_cast<std::size_t>(before);
      if (!HasMajority(session, m)) continue;
      if (WishedLately(session, m)) continue;
      const std::string& name = model_->bodies[body].name;
      if (ownership.authority(body) == hostile_) {
        violations_->Add("a hand loses a body to a hostile member", session.id(m), name);
      } else {
        violations_->Add("a hand loses what it holds", session.id(m), name);
      }
    }
  }

 private:
  /// Returns whether other peers are here and all have known for long enough what this peer holds.
  /// If two peers disagree, nobody can say which is right.
  static bool HasMajority(SimulatedSession& session, std::size_t member) {
    const std::int64_t clear_ns = 2 * session.network().LongestWay() + 1'000'000'000;
    const PeerId id = session.id(member);
    const std::int64_t now_ns = session.now_ns();
    std::size_t others = 0;
    for (std::size_t other = 0; other < session.size(); ++other) {
      if (other == member || !session.present(other)) continue;
      const auto from = session.network().ClearSince(session.id(other), id);
      const auto to = session.network().ClearSince(id, session.id(other));
      if (!from || !to || now_ns - *from < clear_ns || now_ns - *to < clear_ns) return false;
      ++others;
    }
    return others > 0;
  }

  /// Returns whether the user has lately made a wish. Where nothing was cut or halted for long, a
  /// hand loses a body only by such a wish.
  bool WishedLately(SimulatedSession& session, std::size_t member) const {
    constexpr std::int64_t kWish = 100'000'000;
    const auto wished = wished_ns_.find(session.id(member));
    return wished != wished_ns_.end() && session.now_ns() - wished->second < kWish;
  }

  const WorldModel* model_;
  Violations* violations_;
  PeerId hostile_ = 0;  // 0: none
  std::map<PeerId, std::int64_t> wished_ns_;
  std::vector<int> held_;  // indexed by member, a frame ago
};

}  // namespace tandem
