#include <algorithm>
#include <utility>

#include "collab/ownership/ownership.h"
#include "engine/base/units.h"

// Handles claims and events of other peers, and their effect on ours; ownership.cpp handles our
// user's wishes.

namespace tandem {

namespace {

constexpr std::int64_t kMostBeyond = 100;  // epochs; one more is earned in each kEpoch
constexpr std::int64_t kTellAgain = 2000 * kMs;
constexpr std::int64_t kWithdrawn = 5000 * kMs;  // time in which a grant may be on its way
constexpr std::int64_t kLastWords = 500 * kMs;
constexpr std::int64_t kAnswer = 50 * kMs;  // between answers to a peer, after kAnswersAtOnce
constexpr int kAnswersAtOnce = 8;
constexpr std::int64_t kTouching = 250 * kMs;  // since the last touch, or a change of hands

}  // namespace

// As many as peers can raise in the time that the newest peer knows of, so that all believe what
// one believes; each peer may go a little further by its own steps.
std::int64_t Ownership::MostEpoch(const Body& body) const noexcept {
  return std::max(kMostEpochs, body.first_epoch) + EpochsSince(first_ns_);
}

std::int64_t Ownership::EpochsSince(std::int64_t since_ns) const noexcept {
  return (now_ns_ - std::max(since_ns, last_joined_ns_)) / kEpoch;
}

int Ownership::VotesNear(const Body& body, const Member& peer, std::uint32_t epoch) const noexcept {
  const std::int64_t least = epoch - kMostBeyond - EpochsSince(peer.known_ns);
  return static_cast<int>(std::ranges::count_if(members_, [&](const Member& member) {
    if (VoteOf(member, body.index) != peer.peer) return false;
    const Belief* const stated = BeliefOf(member, body.index);
    return (stated != nullptr ? stated->epoch : ClaimOf(member, body.index)->epoch) >= least;
  }));
}

bool Ownership::Affords(const Member& by, const Body& body, std::uint32_t epoch) const noexcept {
  if (epoch == 0 || epoch > kLastEpoch) return false;
  if (epoch <= MostEpoch(body)) return true;
  if (body.claim.peer == 0) {
    // a body far along is known to others too, with an epoch as far along
    const int votes = VotesNear(body, by, epoch);
    return epoch <= kMostAtFirst && 2 * votes >= CountHere() && (votes > 1 || !is_new());
  }
  const std::int64_t from = std::max(MostEpoch(body), std::int64_t{body.claim.epoch});
  return by.epochs + epoch - from <= kMostBeyond + EpochsSince(by.known_ns);
}

bool Ownership::HoldsBeside(const Body& body, const Claim& claim) noexcept {
  return body.shared && claim.held && claim.epoch == body.claim.epoch;
}

void Ownership::NoteClaim(std::size_t index, const Claim& claim, Member& by) noexcept {
  Body& body = bodies_[index];
  const PeerId owner = body.claim.peer;
  if (claim.epoch == 0 || (owner == by.peer && claim.epoch <= body.claim.epoch)) return;
  if (owner == by.peer && body.forsaken) return;
  const bool beside = HoldsBeside(body, claim);
  const bool answers = NamedBy(by, index) == by.peer;
  if (beside && !answers) return;
  const bool lowest = beside && Greater(claim.epoch, by.peer, body);  // lowest of the holders
  if (owner == 0 || (owner != by.peer && !lowest)) {
    if (!body.disputed) body.disputed_ns = now_ns_;
    body.disputed = true;  // judged when all that came with it is known
    return;
  }
  if (!Affords(by, body, claim.epoch)) return Refuse(by.peer, Drop::kEpochLeap);
  Believe(index, {claim.epoch, by.peer}, by, claim.held);
}

void Ownership::Believe(std::size_t index, const BodyClaim& claim, Member& by,
                        bool in_its_hand) noexcept {
  Body& body = bodies_[index];
  const PeerId peer = claim.peer;
  const std::int64_t from = std::max(MostEpoch(body), std::int64_t{body.claim.epoch});
  if (body.claim.peer == 0) body.first_epoch = claim.epoch;
  if (claim.epoch > from) by.epochs += claim.epoch - from;
  if (held_ == static_cast<int>(index) && body.claim.peer == self_) hold_epoch_ = body.claim.epoch;
  const PeerId owner = body.claim.peer;
  if (peer != owner) NoteBefore(body, by.peer == owner || IsHere(owner));
  ForgetAbsent(body, peer);
  for (FormerOwner& before : body.before) {
    if (before.peer == peer) before = {};  // it has the body again
  }
  if (peer != owner) {
    body.claimed_ns = now_ns_;
    body.began_epoch = claim.epoch;
  }
  body.claim = claim;
  body.by_another = by.peer != peer;
  body.forsaken = false;
  // a peer that gets a body again counts on from the epoch under which it had it
  if (peer == self_ && peer != owner && claim.epoch <= body.last_epoch) {
    body.claim.epoch = Next(body.last_epoch);
  }
  body.by_word = false;
  body.orphaned_ns = 0;
  body.handed = false;
  body.passed_on = false;
  if (held_ != static_cast<int>(index) || body.shared || peer == self_) return;
  // another part of the session went on without us, or took it while we were stopped
  held_ = -1;
  Notify(Notification::Kind::kTaken, index, peer);
  if (!in_its_hand) Ask(body.object);
}

void Ownership::NoteBefore(Body& body, bool by_its_word) noexcept {
  body.tied_ns = 0;
  body.ahead_ns = 0;
  body.outdone_ns = 0;
  body.less_ns = 0;
  body.contests = 0;
  const PeerId peer = body.claim.peer;
  if (peer == 0) return;
  if (peer == self_) body.last_epoch = std::max(body.last_epoch, body.claim.epoch);
  // a peer that leaves gives up its bodies
  const Member* const member = members_.Find(peer);
  if (peer == self_ || by_its_word || (member != nullptr && member->left)) {
    std::rotate(body.before.begin(), body.before.end() - 1, body.before.end());
    body.before[0] = {peer, now_ns_};
    return;
  }
  const auto free = std::ranges::find(body.in_absence_of, PeerId{0});
  const bool known = std::ranges::count(body.in_absence_of, peer) != 0;
  if (!known && free != body.in_absence_of.end()) *free = peer;
}

void Ownership::Settle() noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    LookForAbsent(bodies_[b]);
    FollowItsWord(b);
    GoBackToItsOwn(b);
    RiseToNamed(b);
    if (!bodies_[b].disputed) {
      bodies_[b].tied_ns = bodies_[b].ahead_ns = bodies_[b].outdone_ns = 0;
      bodies_[b].contests = 0;
      continue;
    }
    if (bodies_[b].claim.peer == 0) JudgeFirst(b);
    if (bodies_[b].claim.peer != 0) Judge(b);
  }
}

void Ownership::OnEvent(const Event& event) noexcept {
  const int found = BodyOf(event.object);
  if (found < 0 || event.peer == self_ || event.peer == 0) return;
  // the last events of a peer arrive after its goodbye
  const Member* const by = members_.Find(event.peer);
  const bool just_left = by != nullptr && by->left && now_ns_ - by->since_ns < kLastWords;
  if (!IsHere(event.peer) && !just_left) return Refuse(event.peer, Drop::kStranger);
  const auto index = static_cast<std::size_t>(found);
  Body& body = bodies_[index];
  switch (event.kind) {
    case EventKind::kAsk:
      if (event.to == self_) OnAsk(index, event.peer);
      return;
    case EventKind::kTouch:
      if (event.to == self_) OnTouch(index, event.peer);
      return;
    case EventKind::kGrant:
      OnGrant(index, event);
      return;
    case EventKind::kRefuse:
      if (event.to != self_ || wanted_ != found) return;
      if (event.peer != requested_) return Refuse(event.peer, Drop::kNotOwner);
      wanted_ = -1;
      Notify(Notification::Kind::kRefused, index, event.peer);
      return;
    case EventKind::kRelease:
      if (event.to != 0) {
        OnGrant(index, event);
      } else if (event.peer == body.claim.peer && event.epoch == body.claim.epoch) {
        body.parked = event.X_WB;
        body.reported = true;
      } else if (event.peer != body.claim.peer && IsHere(body.claim.peer)) {
        Refuse(event.peer, Drop::kNotOwner);
      }
      return;
    case EventKind::kHeal:
      return;
  }
}

// A peer that asks without end gets few answers: they would use up what this peer may send.
bool Ownership::MayAnswer(PeerId from) noexcept {
  Member& asker = *members_.Find(from);
  asker.answered_ns = std::max(asker.answered_ns, now_ns_);
  if (asker.answered_ns - now_ns_ > kAnswersAtOnce * kAnswer) {
    Refuse(from, Drop::kFlood);
    return false;
  }
  asker.answered_ns += kAnswer;
  return true;
}

void Ownership::OnAsk(std::size_t index, PeerId from) noexcept {
  const Body& body = bodies_[index];
  const bool its_own = body.claim.peer == from;
  if ((!its_own && (authority(index) != self_ || listening())) || !MayAnswer(from)) return;
  if (its_own) {
    // our grant has not reached the asker
    QueueEvent(EventKind::kGrant, index, body.claim.epoch, from);
    return;
  }
  if (body.shared && (held_ == static_cast<int>(index) || HeldByOther(index))) return;
  if (held_ == static_cast<int>(index)) {
    QueueEvent(EventKind::kRefuse, index, body.claim.epoch, from);
    NotifyRequested(index, from);
    return;
  }
  HandOver(index, EventKind::kGrant, from);
}

void Ownership::OnTouch(std::size_t index, PeerId from) noexcept {
  const Body& body = bodies_[index];
  if (!body.free || !IsHere(from)) return;
  if (body.claim.peer == from) {
    // our hand-over has not reached the peer that touches the body
    if (MayAnswer(from)) QueueEvent(EventKind::kRelease, index, body.claim.epoch, from);
    return;
  }
  const bool touched = body.touched_ns != 0 && now_ns_ - body.touched_ns < kTouching;
  // a new owner keeps the body for a while, or two peers that both push it would pass it back and
  // forth
  if (!Parks(index) || listening() || touched || now_ns_ - body.claimed_ns < kTouching) return;
  HandOver(index, EventKind::kRelease, from);
}

void Ownership::NotifyRequested(std::size_t index, PeerId from) noexcept {
  const ObjectId object = bodies_[index].object;
  const Requester* const known = requesters_.Find(from);
  if (known != nullptr && known->object == object && now_ns_ - known->reported_ns < kTellAgain)
    return;
  Requester* place = requesters_.FindOrInsert(from);
  if (place == nullptr) {  // a new asker takes the place of the peer that asked longest ago
    requesters_.Erase(std::ranges::min_element(requesters_, {}, &Requester::reported_ns)->peer);
    place = requesters_.FindOrInsert(from);
  }
  *place = {from, object, now_ns_};
  Notify(Notification::Kind::kAsked, index, from);
}

void Ownership::HandOver(std::size_t index, EventKind kind, PeerId to) noexcept {
  Body& body = bodies_[index];
  NoteBefore(body, true);
  body.claim = {Next(body.claim.epoch), to};
  body.began_epoch = body.claim.epoch;
  body.claimed_ns = now_ns_;
  body.unsure = false;
  body.parked = body.X_WB;
  body.reported = kind == EventKind::kRelease;
  body.orphaned_ns = 0;
  body.by_another = false;
  body.by_word = false;
  body.handed = true;
  body.handed_by = kind;
  body.sent_ns = now_ns_;
  QueueEvent(kind, index, body.claim.epoch, to);
}

void Ownership::OnGrant(std::size_t index, const Event& event) noexcept {
  if (event.to == 0) return;
  Body& body = bodies_[index];
  const bool known = body.claim.epoch == event.epoch && body.claim.peer == event.to;
  // the grant by which the body came to us, not one under an epoch that we have risen to since
  const bool awaited = known && event.to == self_ && event.epoch == body.began_epoch;
  if (awaited && std::exchange(body.by_word, false)) return TakeGiven(index, event);
  if (known || !Greater(event.epoch, event.to, body)) return;
  const PeerId owner = body.claim.peer;
  const bool ours = owner == self_ && held_ == static_cast<int>(index) && body.shared;
  if (ours && event.to == self_ && event.kind == EventKind::kRelease) {
    // it took our body beside us, and let go of it again before we heard of that
    if (event.epoch <= MostEpoch(body)) RiseTo(body, event.epoch);
    return;
  }
  // each of several holders may leave the body to another of them as it lets go, for it takes a
  // while until all know the lowest
  Member& from = *members_.Find(event.peer);
  const Claim* const held = ClaimOf(from, body.index);
  const bool beside = body.shared && event.kind == EventKind::kRelease && held != nullptr &&
                      held->held && held->epoch >= body.claim.epoch && HeldBy(index, event.to);
  // where the authority is gone, the lowest peer may have taken over already, and any peer may pass
  // on a grant to another that is gone
  const bool lost = owner != self_ && (!IsHere(owner) || body.forsaken);
  const bool in_turn = event.peer == LowestOther(-1) ||
                       (body.shared && event.peer == LowestOther(static_cast<int>(index)));
  const bool passed_on = owner != 0 && event.to != self_ && !IsHere(event.to);
  const bool gone = lost && (in_turn || passed_on);
  // the authority's word may be heard before the events that led to it
  const bool stated = SaysGoneTo(body, event.peer);
  if (event.to == event.peer || (!stated && !gone && !beside)) {
    return Refuse(event.peer, Drop::kNotOwner);
  }
  if (!Affords(from, body, event.epoch)) return Refuse(event.peer, Drop::kEpochLeap);
  Believe(index, {event.epoch, event.to}, from, event.kind == EventKind::kGrant);
  TakeGiven(index, event);
}

void Ownership::TakeGiven(std::size_t index, const Event& event) noexcept {
  Body& body = bodies_[index];
  // a body granted to another peer is about to move
  body.parked = event.X_WB;
  body.reported = event.to == self_ ? !body.free : event.kind == EventKind::kRelease;
  if (event.to != self_) return;
  const int b = static_cast<int>(index);
  // a body put into our hand unasked is taken if the hand is empty; a body that was asked for and
  // is not wanted any more is not unasked
  const bool withdrawn = body.withdrawn_ns != 0 && now_ns_ - body.withdrawn_ns < kWithdrawn;
  const bool given = event.kind == EventKind::kGrant && held_ < 0 && wanted_ < 0 && !withdrawn &&
                     !stopped_ && !(own_only_ && body.shared);
  if (wanted_ != b && !given) return;
  if (IsInAnothersHand(index)) {
    wanted_ = b;
    wanted_since_ns_ = now_ns_;
    return;
  }
  TakeInHand(index);
}

void Ownership::OnState(const ObjectState& state) noexcept {
  const int found = BodyOf(state.object);
  if (found < 0) return;
  Body& body = bodies_[static_cast<std::size_t>(found)];
  body.parked = state.X_WB;
  body.reported = (state.flags & kStateParked) != 0;
}

}  // namespace tandem
