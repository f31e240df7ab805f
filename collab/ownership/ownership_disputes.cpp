#include <algorithm>

#include "collab/ownership/ownership.h"
#include "engine/base/units.h"

// Decides which claim counts where several peers claim one body.
// docs/decisions/0036-who-may-say-what.md

namespace tandem {

namespace {

constexpr std::int64_t kReassertAgain = 1000 * kMs;
constexpr std::int64_t kAfterPause = 5000 * kMs;  // until we know what we missed in a pause
constexpr std::int64_t kAhead = 200 * kMs;        // time in which an authority may yield by itself
constexpr std::int64_t kTied = 200 * kMs;         // until the higher of two equal peers yields
constexpr std::int64_t kSilent = 3000 * kMs;      // silence of an authority about its body
// until we follow a lesser claim after its claimant did not raise it
constexpr std::int64_t kOutdone = 3000 * kMs;
constexpr int kMostContests = 2;  // claims above an equal one until the higher of two peers yields
constexpr std::int64_t kTakenOver = 300 * kMs;  // until the next in line has a lost peer's body
constexpr std::int64_t kMostAhead = 50;         // epochs beyond the greatest that any word affords

}  // namespace

void Ownership::ForgetAbsent(Body& body, PeerId from) noexcept {
  const auto first = std::ranges::find(body.in_absence_of, from);
  if (from != 0) std::fill(first, body.in_absence_of.end(), PeerId{0});
}

// A peer in whose absence the body came to the believed one may be back. If it agrees, it and the
// peers missed after it are forgotten.
void Ownership::LookForAbsent(Body& body) noexcept {
  for (const PeerId peer : body.in_absence_of) {
    const Member* const member = members_.Find(peer);
    if (member == nullptr || !member->present) continue;
    if (NamedBy(*member, body.index) == body.claim.peer) return ForgetAbsent(body, peer);
  }
  if (body.unsure && now_ns_ - body.unsure_ns > kAllTold) body.unsure = false;
}

// The owner of a body says where it went, of which we may not have heard otherwise.
void Ownership::FollowItsWord(std::size_t index) noexcept {
  Body& body = bodies_[index];
  for (int hands = 0; hands < 4; ++hands) {
    Member* const owner = body.claim.peer == self_ ? nullptr : members_.Find(body.claim.peer);
    if (owner == nullptr || !owner->present || body.forsaken) return;
    // its claim may have been heard before it was believed
    const Claim* const own = ClaimOf(*owner, body.index);
    if (own != nullptr && own->epoch > body.claim.epoch &&
        NamedBy(*owner, body.index) == owner->peer && Affords(*owner, body, own->epoch)) {
      Believe(index, {own->epoch, owner->peer}, *owner, own->held);
    }
    const Belief* const stated = BeliefOf(*owner, body.index);
    if (stated == nullptr || stated->peer == 0 || stated->peer == owner->peer) return;
    if (!Greater(stated->epoch, stated->peer, body) || !Affords(*owner, body, stated->epoch))
      return;
    const bool ours = stated->peer == self_;
    Believe(index, {stated->epoch, stated->peer}, *owner, false);
    body.by_word = ours;
  }
}

// The claimant refuses to count on from another's word about it, so only peers that this word
// misled follow it. To take the body over from there would spread the error.
void Ownership::GoBackToItsOwn(std::size_t index) noexcept {
  Body& body = bodies_[index];
  const bool here = body.claim.peer != self_ && IsHere(body.claim.peer) && !body.forsaken;
  Member* const owner = here && body.by_another ? members_.Find(body.claim.peer) : nullptr;
  const Claim* const own = owner == nullptr ? nullptr : ClaimOf(*owner, index);
  if (own == nullptr || own->epoch == 0 || own->epoch >= body.claim.epoch ||
      NamedBy(*owner, index) != owner->peer) {
    body.less_ns = 0;
    return;
  }
  if (body.less_ns == 0) body.less_ns = now_ns_;
  if (now_ns_ - body.less_ns < kOutdone || listening()) return;
  body.less_ns = 0;
  body.began_epoch = std::min(body.began_epoch, own->epoch);
  Believe(index, {own->epoch, owner->peer}, *owner, own->held);
}

// The other peers refuse our states until they have heard of our new epoch. So a peer that would
// have us rise all the time is heeded once in a while, if a shared body is in our hand. Any other
// body can be taken from us.
void Ownership::RiseTo(Body& body, std::uint32_t epoch) noexcept {
  if (epoch <= body.claim.epoch) return;
  const bool coupled = body.shared && held_ == static_cast<int>(body.index);
  if (coupled && body.risen_ns != 0 && now_ns_ - body.risen_ns < kReassertAgain) return;
  body.risen_ns = now_ns_;
  body.claim.epoch = epoch;
}

// Other peers may believe a greater epoch than we claim, of us or of a peer that is gone or follows
// us. They have it from a lost part of the session, or from a peer that may not say so. We count on
// from there.
void Ownership::RiseToNamed(std::size_t index) noexcept {
  Body& body = bodies_[index];
  if (body.claim.peer != self_ || listening()) {
    body.tied_with_named_ns = 0;
    return;
  }
  const auto said_by = [&](const Member& member) -> const Belief* {
    const Belief* const stated = member.present ? BeliefOf(member, body.index) : nullptr;
    return stated != nullptr && stated->epoch <= MostEpoch(body) ? stated : nullptr;
  };
  std::uint32_t ours = 0;
  for (const Member& member : members_) {
    const Belief* const stated = said_by(member);
    if (stated != nullptr && stated->peer == self_) ours = std::max(ours, stated->epoch);
  }
  RiseTo(body, ours);
  std::uint32_t above = 0;
  bool is_another_lower = false;
  for (const Member& member : members_) {
    const Belief* const stated = said_by(member);
    if (stated == nullptr || stated->peer == self_) continue;
    const Member* const named = members_.Find(stated->peer);
    if (named == nullptr || !named->present || NamedBy(*named, body.index) == self_) {
      above = std::max(above, stated->epoch);
      is_another_lower |= stated->epoch == body.claim.epoch && stated->peer < self_;
    }
  }
  // a peer that took a shared body in hand beside us answers for it, and others may have heard of
  // that first
  const bool may_say_so = body.shared && is_another_lower && above == body.claim.epoch;
  if (!may_say_so) body.tied_with_named_ns = 0;
  if (above < body.claim.epoch) return;
  if (may_say_so && body.tied_with_named_ns == 0) body.tied_with_named_ns = now_ns_;
  if (!may_say_so || now_ns_ - body.tied_with_named_ns >= kAhead) Reassert(index, above);
}

// Where no owner is known, the claimant with the most votes gets the body; among equal ones that
// with the least claim, since all can count on from there.
void Ownership::JudgeFirst(std::size_t index) noexcept {
  Body& body = bodies_[index];
  const PeerId lowest = authority(index);
  Member* best = nullptr;
  const Claim* claim = nullptr;
  int most = 0;
  body.disputed = false;
  for (Member& member : members_) {
    const Claim* own = member.present ? ClaimOf(member, body.index) : nullptr;
    if (own == nullptr || own->epoch == 0) continue;
    body.disputed = true;  // a claim beyond belief may be believed later
    if (!Affords(member, body, own->epoch)) {
      CountOnce(member, *own, Drop::kEpochLeap);
      continue;
    }
    const int votes = VotesFor(body, member.peer);
    const bool less = best == nullptr || own->epoch < claim->epoch ||
                      (own->epoch == claim->epoch && member.peer > best->peer);
    if (best != nullptr && (votes < most || (votes == most && !less))) continue;
    best = &member;
    claim = own;
    most = votes;
  }
  if (best == nullptr) return;
  Believe(index, {claim->epoch, best->peer}, *best, claim->held);
  body.unsure = true;
  body.unsure_ns = now_ns_;
  // the authority of an unclaimed body has not said yet that it gave the body away
  if (lowest != best->peer && lowest != self_) body.in_absence_of[0] = lowest;
}

Ownership::Rival Ownership::RivalOf(std::size_t index, bool claims_more) noexcept {
  Body& body = bodies_[index];
  Rival best;
  for (Member& member : members_) {
    if (!member.present || member.peer == body.claim.peer) continue;
    const Claim* own = ClaimOf(member, body.index);
    if (own == nullptr || own->epoch == 0) continue;
    if (Greater(own->epoch, member.peer, body) != claims_more) continue;
    // a holder beside others names another authority
    if (NamedBy(member, body.index) != member.peer) continue;
    body.disputed = true;
    if (claims_more && !Affords(member, body, own->epoch)) {
      CountOnce(member, *own, Drop::kEpochLeap);
      continue;
    }
    const int votes = VotesFor(body, member.peer);
    const bool greater = best.member == nullptr || own->epoch > best.claim->epoch ||
                         (own->epoch == best.claim->epoch && member.peer < best.member->peer);
    if (best.member == nullptr || votes > best.votes || (votes == best.votes && greater)) {
      best = {&member, own, votes};
    }
  }
  return best;
}

bool Ownership::KeepsOurs(std::size_t index, const Rival& rival) noexcept {
  Body& body = bodies_[index];
  const Member& other = *rival.member;
  const bool was_away = other.since_ns >= body.claimed_ns;
  // nor does a peer give a body away to have it again, and another run of it brings nothing back
  if ((!was_away || other.anew) && HadItRecently(body, other.peer)) return true;
  // while we were stopped others may have taken our body; our own vote counts only with another's
  const bool is_named = VotesFor(body, self_) > 0;
  const bool was_stopped =
      !is_named && body.claimed_ns <= paused_ns_ && now_ns_ - paused_ns_ < kAfterPause;
  const int votes = (was_stopped ? 0 : 1) + VotesAgainst(body, other.peer);
  const bool in_hand = !body.shared && held_ == static_cast<int>(index);
  // votes older than our claim take nothing out of a hand
  const bool in_doubt = body.in_absence_of[0] != 0 && rival.claim->held;
  const int stale = in_hand && !in_doubt ? StaleFor(body, other.peer) : 0;
  body.undecided = stale > 0 && votes <= rival.votes;
  if (votes != rival.votes - stale) {
    body.tied_ns = 0;
    body.contests = 0;
    return votes > rival.votes - 2 * stale;
  }
  if (body.undecided) return true;
  if (was_stopped) return false;
  if (HadItRecently(body, other.peer)) return true;
  // the hand keeps it, unless a newcomer still has to be heard
  if (!body.shared && in_hand != rival.claim->held && !IsHearsay(body, other.peer)) return in_hand;
  if (body.in_absence_of[0] != 0 || body.unsure) return false;
  // nor do we keep a body that we took in hand while another peer, named by others, had it in hand:
  // their votes come late
  const bool came_later = in_hand && rival.claim->held && rival.votes > 1 &&
                          other.held_before == static_cast<int>(index);
  if (other.peer > self_ && !came_later) return true;
  if (!was_away && !came_later) {
    // each has the body by a word that the other did not hear, and its sender is gone
    body.even = true;
    return in_hand || body.contests < kMostContests;
  }
  if (body.tied_ns == 0) body.tied_ns = now_ns_;
  return now_ns_ - body.tied_ns < kTied;
}

bool Ownership::IsInAnothersHand(std::size_t index) const noexcept {
  const Body& body = bodies_[index];
  if (body.shared) return false;
  const bool sure = IsSure(body);
  const int ours = VotesFor(body, self_) + (sure ? 1 : 0);
  return std::ranges::any_of(members_, [&](const Member& member) {
    if (!HeldBy(index, member.peer)) return false;
    if (NamedBy(member, index) != member.peer) return false;
    const int votes = VotesFor(body, member.peer);
    return sure ? votes > ours : votes >= ours;
  });
}

// Returns whether we leave an owner that is here and claims its body, for a rival.
bool Ownership::IsAhead(const Body& body, const Rival& rival) const noexcept {
  const bool is_less = !Greater(rival.claim->epoch, rival.member->peer, body);
  // by the word of the believed owner
  if (GoneTo(body, is_less) == rival.member->peer) return true;
  const int votes = VotesAgainst(body, rival.member->peer) + (IsSure(body) ? 1 : 0);
  if (rival.votes != votes) return rival.votes > votes;
  return SaidByReturned(body, rival.member->peer);
}

bool Ownership::LeavesFor(std::size_t index, const Rival& rival) noexcept {
  Body& body = bodies_[index];
  const Member* const owner = members_.Find(body.claim.peer);
  if (owner == nullptr || body.forsaken) return true;
  if (!owner->present) {
    if (owner->left) return true;
    // it got the body after we lost it, so others still hear it
    const bool is_heard = body.claimed_ns > owner->since_ns;
    if (now_ns_ - owner->since_ns > kSilent) return true;
    if (is_heard) return rival.votes > VotesAgainst(body, rival.member->peer);
    return now_ns_ - owner->since_ns > kTakenOver;
  }
  const PeerId at = GoneTo(body);
  if (at == rival.member->peer) return true;
  // it says nothing of its body, or a peer that it named says nothing
  const bool silent = at != body.claim.peer || ClaimOf(*owner, body.index) == nullptr;
  if (silent) return body.orphaned_ns != 0 && now_ns_ - body.orphaned_ns > kSilent;
  if (!IsAhead(body, rival)) {
    body.ahead_ns = 0;
    return false;
  }
  if (body.ahead_ns == 0) body.ahead_ns = now_ns_;
  return now_ns_ - body.ahead_ns >= kAhead;
}

// Returns whether a lesser claim counts again: its claimant did not raise it above the claim that
// misled us.
bool Ownership::GoesBackTo(std::size_t index, const Rival& rival) noexcept {
  Body& body = bodies_[index];
  const bool is_here = IsHere(body.claim.peer) && !body.forsaken;
  if (body.claim.peer == self_ || HadItRecently(body, rival.member->peer) ||
      (is_here && !IsAhead(body, rival))) {
    body.outdone_ns = 0;
    return false;
  }
  if (body.outdone_ns == 0) body.outdone_ns = now_ns_;
  // others may have heard a peer that is gone until it went
  const Member* const owner = members_.Find(body.claim.peer);
  const std::int64_t gone_ns = is_here || owner == nullptr ? 0 : owner->since_ns;
  return now_ns_ - std::max(body.outdone_ns, gone_ns) >= kOutdone;
}

void Ownership::Judge(std::size_t index) noexcept {
  Body& body = bodies_[index];
  body.disputed = false;
  body.undecided = false;
  body.even = false;
  const Rival rival = RivalOf(index, true);
  const Rival lesser = RivalOf(index, false);
  if (lesser.member == nullptr) body.outdone_ns = 0;
  if (rival.member == nullptr) body.ahead_ns = 0;
  if (lesser.member != nullptr && GoesBackTo(index, lesser)) return Follow(index, lesser);
  // The peer in whose absence we took the body is back, and more votes follow its claim than ours,
  // with an epoch as late as ours began. To wait until its claim exceeds ours takes two more
  // message delays.
  const auto is_outnamed = [&] {
    const PeerId peer = lesser.member->peer;
    if (body.claim.peer != self_ || listening()) return false;
    if (lesser.claim->epoch < body.began_epoch || HadItRecently(body, peer)) return false;
    if (!SaidByReturned(body, peer)) return false;
    return lesser.votes - StaleFor(body, peer) > 1 + VotesAgainst(body, peer);
  };
  if (lesser.member != nullptr && is_outnamed()) return Follow(index, lesser);
  if (rival.member == nullptr) return;
  // the lowest of several holders answers, even if it was heard first
  if (HoldsBeside(body, *rival.claim)) return Follow(index, rival);
  const bool ours = body.claim.peer == self_;
  if (ours ? !KeepsOurs(index, rival) : LeavesFor(index, rival)) return Follow(index, rival);
  // a third peer's body may have been given away without our knowledge; and two peers that were
  // apart may both claim an unclaimed body, without taking it from each other
  const bool both_first = body.free && rival.claim->epoch == 1 && !rival.claim->held;
  if (!both_first && (ours || now_ns_ - body.disputed_ns > kAllTold)) {
    CountOnce(*rival.member, *rival.claim, Drop::kSeized);
  }
  // a peer that is about to yield, or waits for votes, does not claim the body again
  if (!ours || body.tied_ns != 0 || body.undecided) return;
  if (Reassert(index, rival.claim->epoch) && body.even) ++body.contests;
}

void Ownership::Follow(std::size_t index, const Rival& rival) noexcept {
  const BodyClaim claim{rival.claim->epoch, rival.member->peer};
  Believe(index, claim, *rival.member, rival.claim->held);
}

void Ownership::CountOnce(Member& member, const Claim& claim, Drop reason) noexcept {
  if (member.refused == claim) return;
  member.refused = claim;
  Refuse(member.peer, reason);
}

bool Ownership::Reassert(std::size_t index, std::uint32_t above) noexcept {
  Body& body = bodies_[index];
  if (listening() || above < body.claim.epoch) return false;
  if (body.reasserted_ns != 0 && now_ns_ - body.reasserted_ns < kReassertAgain) return false;
  // the others would not believe more
  const std::int64_t from = std::max(MostEpoch(body), std::int64_t{body.claim.epoch});
  const std::int64_t most = from + kMostAhead + EpochsSince(first_ns_) / 2 - own_epochs_;
  if (above >= most) return false;
  own_epochs_ += std::max<std::int64_t>(0, std::int64_t{above} + 1 - from);
  body.reasserted_ns = now_ns_;
  body.claim.epoch = above + 1;
  return true;
}

}  // namespace tandem
