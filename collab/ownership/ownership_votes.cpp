#include <algorithm>

#include "collab/ownership/ownership.h"
#include "engine/base/units.h"

// Counts which peers name which authority, and follows what they say of a body.
// docs/decisions/0036-who-may-say-what.md

namespace tandem {

namespace {

constexpr std::int64_t kHearsay = 1000 * kMs;  // until a newcomer has heard the other peers, too

}  // namespace

const Belief* Ownership::BeliefOf(const Member& member, std::size_t body) noexcept {
  return body < kMaxClaims && member.beliefs[body] ? &*member.beliefs[body] : nullptr;
}

PeerId Ownership::NamedBy(const Member& member, std::size_t body) noexcept {
  // a holder beside others also says which peer is the authority
  if (const Belief* belief = BeliefOf(member, body)) return belief->peer;
  return ClaimOf(member, body) != nullptr ? member.peer : 0;
}

bool Ownership::HadItRecently(const Body& body, PeerId peer) const noexcept {
  return std::ranges::any_of(body.before, [&](const FormerOwner& before) {
    return before.peer == peer && now_ns_ - before.until_ns < kAllTold;
  });
}

// The peer that a member names, where that is a vote: a newcomer has it from hearsay.
PeerId Ownership::VoteOf(const Member& member, std::size_t body) const noexcept {
  if (!member.present) return 0;
  const PeerId named = NamedBy(member, body);
  return named == member.peer || now_ns_ - member.known_ns > kHearsay ? named : 0;
}

bool Ownership::IsStale(const Member& member, const Body& body, PeerId named) const noexcept {
  const Belief* const belief = BeliefOf(member, body.index);
  return belief != nullptr && named != member.peer && belief->epoch < body.began_epoch &&
         now_ns_ - body.claimed_ns < kAllTold;
}

bool Ownership::IsSure(const Body& body) const noexcept {
  return !body.unsure && body.in_absence_of[0] == 0 && !is_new();
}

int Ownership::VotesFor(const Body& body, PeerId peer) const noexcept {
  return static_cast<int>(std::ranges::count_if(members_, [&](const Member& member) {
    return VoteOf(member, body.index) == peer;
  }));
}

int Ownership::VotesAgainst(const Body& body, PeerId rival) const noexcept {
  int votes = 0;
  for (const Member& member : members_) {
    const PeerId named = VoteOf(member, body.index);
    if (named == 0 || named == rival) continue;
    // a member that names a recent owner has not heard yet
    votes +=
        named == body.claim.peer || (named != member.peer && HadItRecently(body, named)) ? 1 : 0;
  }
  return votes;
}

// Returns the peer to which the body went by the authority's word, followed through several hands.
// A peer that names another under an epoch that is not greater has not heard yet that it has the
// body itself; its word counts only if `by_any_word`.
PeerId Ownership::GoneTo(const Body& body, bool by_any_word) const noexcept {
  BodyClaim at = body.claim;
  for (int hands = 0; hands < 4; ++hands) {
    const Member* member = members_.Find(at.peer);
    if (member == nullptr || !member->present) return at.peer;
    const Belief* const stated = BeliefOf(*member, body.index);
    if (stated == nullptr || stated->peer == 0 || stated->peer == at.peer) return at.peer;
    const bool is_above =
        stated->epoch > at.epoch || (stated->epoch == at.epoch && stated->peer < at.peer);
    if (!is_above && !by_any_word) return at.peer;
    at = {stated->epoch, stated->peer};
  }
  return at.peer;
}

bool Ownership::SaysGoneTo(const Body& body, PeerId peer) const noexcept {
  if (body.forsaken) return false;
  BodyClaim at = body.claim;
  for (int hands = 0; hands < 4; ++hands) {
    if (at.peer == peer) return true;
    const Member* member = members_.Find(at.peer);
    if (member == nullptr || !member->present) return false;
    const Belief* const stated = BeliefOf(*member, body.index);
    if (stated == nullptr || stated->peer == 0) return false;
    if (stated->epoch < at.epoch || (stated->epoch == at.epoch && stated->peer > at.peer))
      return false;
    at = {stated->epoch, stated->peer};
  }
  return at.peer == peer;
}

bool Ownership::SaidByReturned(const Body& body, PeerId peer) const noexcept {
  return std::ranges::any_of(body.in_absence_of, [&](PeerId absent) {
    const Member* const member = members_.Find(absent);
    return member != nullptr && member->present && NamedBy(*member, body.index) == peer;
  });
}

bool Ownership::IsHearsay(const Body& body, PeerId peer) const noexcept {
  return std::ranges::any_of(members_, [&](const Member& member) {
    return member.present && NamedBy(member, body.index) == peer &&
           VoteOf(member, body.index) != peer;
  });
}

int Ownership::StaleFor(const Body& body, PeerId peer) const noexcept {
  return static_cast<int>(std::ranges::count_if(members_, [&](const Member& member) {
    return VoteOf(member, body.index) == peer && IsStale(member, body, peer);
  }));
}

}  // namespace tandem
