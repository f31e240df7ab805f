#include "collab/simulated/checkers/authority_checker.h"

#include <algorithm>

#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kSettle = 300'000'000;
constexpr std::int64_t kMisled = 3'500'000'000;  // longest time for which a hostile member may
                                                 // mislead
constexpr std::int64_t kBeat = 200'000'000;
constexpr std::int64_t kNextInLine = 1'500'000'000;
constexpr std::int64_t kPause = 505'000'000;  // with room for a drifting clock
constexpr std::int64_t kListen = 295'000'000;

}  // namespace

AuthorityChecker::AuthorityChecker(const WorldModel& model, Violations& violations)
    : model_(&model), violations_(&violations) {}

AuthorityChecker::Known AuthorityChecker::ClaimAt(SimulatedSession& session, std::size_t member,
                                                  std::size_t body) {
  const Ownership& ownership = session.node(member).peer().ownership();
  return {ownership.epoch(body), ownership.authority(body)};
}

void AuthorityChecker::Check(SimulatedSession& session) {
  now_ns_ = session.now_ns();
  way_ns_ = session.network().LongestWay();
  const std::size_t before = ids_.size();
  for (std::size_t m = before; m < session.size(); ++m) ids_.push_back(session.id(m));
  came_ns_.resize(session.size(), now_ns_);
  gone_ns_.resize(session.size(), 0);
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (!session.present(m) && gone_ns_[m] == 0) gone_ns_[m] = now_ns_;
  }
  awake_ns_.resize(session.size(), now_ns_);
  halted_ns_.resize(session.size(), 0);
  silent_ns_.resize(session.size(), 0);
  known_.resize(session.size(), std::vector<Known>(model_->bodies.size()));
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (session.halted(m)) {
      awake_ns_[m] = now_ns_;
      if (halted_ns_[m] == 0) halted_ns_[m] = now_ns_;
    } else if (halted_ns_[m] != 0) {
      if (now_ns_ - halted_ns_[m] > kPause) silent_ns_[m] = now_ns_ + kListen;
      halted_ns_[m] = 0;
    }
  }
  CheckClaims(session);

  std::vector<Part> parts;
  for (std::vector<std::size_t>& members : SettledParts(session)) {
    const auto same = std::find_if(parts_.begin(), parts_.end(), [&](const Part& part) {
      return part.members == members;
    });
    if (same != parts_.end()) {
      parts.push_back(std::move(*same));
      continue;
    }
    Part& part = parts.emplace_back();
    part.members = std::move(members);
    part.agreed_ns.assign(model_->bodies.size(), now_ns_);
    part.one_ns.assign(model_->bodies.size(), now_ns_);
    part.greatest.resize(model_->bodies.size());
    part.stated.resize(model_->bodies.size());
    part.said_ns.resize(model_->bodies.size());
  }
  parts_ = std::move(parts);
  CheckStatements();
  for (Part& part : parts_) CheckPart(session, part);
}

void AuthorityChecker::CheckClaims(SimulatedSession& session) {
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (!session.present(m) || session.halted(m)) continue;
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      const Known now = ClaimAt(session, m, b);
      // epoch 0 is no claim: it names the lowest of the peers that happen to be here
      if (now.epoch > 0 || known_[m][b].epoch > 0) {
        if (known_[m][b].epoch > 0 && now < known_[m][b] && !MayGoBack(session, m, b)) {
          violations_->Add("a claim goes back", ids_[m], model_->bodies[b].name);
        }
        known_[m][b] = now;
      }
    }
  }
}

bool AuthorityChecker::MayGoBack(SimulatedSession& session, std::size_t member, std::size_t body) {
  if (hostile_ != 0) return true;
  // the claimant is gone, or does not go by its claim
  const PeerId from = known_[member][body].peer;
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (!session.present(m) || ids_[m] != from) continue;
    return ClaimAt(session, m, body).peer != from;
  }
  return true;
}

std::vector<std::vector<std::size_t>> AuthorityChecker::SettledParts(
    const SimulatedSession& session) {
  const SimulatedNetwork& network = session.network();
  std::vector<std::size_t> running;
  for (std::size_t m = 0; m < session.size(); ++m) {
    if (session.present(m) && !session.halted(m)) running.push_back(m);
  }
  const auto touch = [&](std::size_t a, std::size_t b) {
    const PeerId p = ids_[a];
    const PeerId q = ids_[b];
    return !network.IsCut(p, q) || !network.IsCut(q, p) || network.ClearSince(p, q) ||
           network.ClearSince(q, p);
  };
  std::vector<std::vector<std::size_t>> settled;
  std::vector<bool> taken(session.size(), false);
  for (const std::size_t first : running) {
    if (taken[first]) continue;
    std::vector<std::size_t> part{first};
    taken[first] = true;
    for (std::size_t i = 0; i < part.size(); ++i) {
      for (const std::size_t m : running) {
        if (taken[m] || !touch(part[i], m)) continue;
        taken[m] = true;
        part.push_back(m);
      }
    }
    std::sort(part.begin(), part.end());
    const std::int64_t since_ns = now_ns_ - 2 * way_ns_ - kSettle;
    const bool is_settled = std::all_of(part.begin(), part.end(), [&](std::size_t a) {
      return awake_ns_[a] <= since_ns && std::all_of(part.begin(), part.end(), [&](std::size_t b) {
               if (a == b) return true;
               const auto clear_ns = network.ClearSince(ids_[a], ids_[b]);
               return clear_ns && *clear_ns <= since_ns;
             });
    });
    if (is_settled) settled.push_back(std::move(part));
  }
  return settled;
}

void AuthorityChecker::CheckPart(SimulatedSession& session, Part& part) {
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    int hands = 0;
    Known greatest;
    bool agree = true;
    bool one = true;
    bool here = true;
    for (const std::size_t m : part.members) {
      hands += session.node(m).peer().ownership().held() == static_cast<int>(b) ? 1 : 0;
      const Known claim = ClaimAt(session, m, b);
      if (greatest.peer != 0) agree = agree && claim == greatest;
      if (greatest.peer != 0) one = one && claim.peer == greatest.peer;
      if (greatest.peer == 0 || greatest < claim) greatest = claim;
      const bool is_here =
          std::any_of(part.members.begin(), part.members.end(), [&](std::size_t o) {
            return ids_[o] == claim.peer;
          });
      here = here && is_here;
    }
    const PeerId first = ids_[part.members.front()];
    const std::string& name = model_->bodies[b].name;
    if (hands > 1 && !model_->scene.bodies[model_->object[b]].shared) {
      violations_->Add("one body is in two hands", first, name);
    }
    if ((agree && here) || !(part.greatest[b] == greatest)) part.agreed_ns[b] = now_ns_;
    part.greatest[b] = greatest;
    if (one) part.one_ns[b] = now_ns_;
    if (hostile_ != 0 && greatest.peer == hostile_) continue;
    const std::int64_t lasts_ns = now_ns_ - part.agreed_ns[b];
    std::int64_t most_ns = 2 * way_ns_ + kSettle + (hostile_ == 0 ? 0 : kMisled);
    if (!here) {
      most_ns += SimulatedNetwork::kLeaseNs + kBeat + kNextInLine * CameSince(part, greatest.peer);
    }
    if (lasts_ns <= most_ns) continue;
    violations_->Add(
        here ? "peers do not agree who answers for a body" : "nobody answers for a body", first,
        name + Text(" for %.2f s", ToSeconds(lasts_ns)));
  }
}

AuthorityChecker::Part* AuthorityChecker::PartOf(PeerId peer) {
  for (Part& part : parts_) {
    for (const std::size_t m : part.members) {
      if (ids_[m] == peer) return &part;
    }
  }
  return nullptr;
}

std::int64_t AuthorityChecker::CameSince(const Part& part, PeerId gone) const {
  std::int64_t count = 0;
  for (std::size_t g = 0; g < ids_.size(); ++g) {
    if (ids_[g] != gone || gone_ns_[g] == 0) continue;
    count += std::ranges::count_if(part.members, [&](std::size_t m) {
      return came_ns_[m] >= gone_ns_[g];
    });
  }
  return count;
}

void AuthorityChecker::OnState(PeerId from, const ObjectState& state) {
  const bool known =
      state.object < model_->body_index.size() && model_->body_index[state.object] >= 0;
  if (!known) return violations_->Add("a state of no body", from);
  const bool parked = (state.flags & kStateParked) != 0;
  // every holder of a shared body publishes its own
  if (model_->scene.bodies[state.object].shared && !parked) return;
  stated_.push_back({from,
                     static_cast<std::size_t>(model_->body_index[state.object]),
                     {state.epoch, state.peer}});
}

void AuthorityChecker::CheckStatements() {
  for (const Statement& says : stated_) {
    for (std::size_t m = 0; m < ids_.size(); ++m) {
      if (ids_[m] != says.from || now_ns_ >= silent_ns_[m]) continue;
      violations_->Add("one who was stopped speaks before it has listened", says.from);
    }
    Part* const part = PartOf(says.from);
    if (part == nullptr) continue;
    Known& greatest = part->stated[says.body];
    const std::int64_t most_ns = hostile_ == 0 ? 0 : 2 * way_ns_ + kSettle + kMisled;
    const bool arrived = hostile_ == 0 || now_ns_ - part->said_ns[says.body] > most_ns;
    if (arrived && says.claim < greatest && says.claim.peer != greatest.peer) {
      violations_->Add("two say where a body is", says.from,
                       model_->bodies[says.body].name + " after " + std::to_string(greatest.peer));
    }
    if (!(greatest < says.claim)) continue;
    if (greatest.peer != says.claim.peer) part->said_ns[says.body] = now_ns_;
    greatest = says.claim;
  }
  stated_.clear();
}

void AuthorityChecker::CheckEnd(SimulatedSession& session, std::int64_t quiet_ns) {
  const std::int64_t most_ns = 2 * way_ns_ + kSettle + (hostile_ == 0 ? 0 : kMisled);
  for (const Part& part : parts_) {
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      const std::int64_t lasts_ns = now_ns_ - std::max(part.one_ns[b], quiet_ns);
      if (part.one_ns[b] == now_ns_ || lasts_ns <= most_ns) continue;
      violations_->Add("peers claim a body above one another", ids_[part.members.front()],
                       model_->bodies[b].name);
    }
  }
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    for (std::size_t m = 0; m < session.size(); ++m) {
      if (!session.present(m)) continue;
      const PeerId authority = session.node(m).peer().ownership().authority(b);
      std::size_t at = 0;
      while (at < session.size() && !(session.present(at) && session.id(at) == authority)) ++at;
      const bool answers =
          at < session.size() && session.node(at).peer().ownership().authority(b) == authority;
      if (answers) continue;
      violations_->Add("nobody answers for a body though all is quiet", session.id(m),
                       model_->bodies[b].name);
    }
  }
}

}  // namespace tandem
