#include <algorithm>
#include <utility>

#include "collab/ownership/ownership.h"
#include "engine/base/units.h"

// Takes over the bodies whose authority is gone, or does not answer for them.

namespace tandem {

namespace {

constexpr std::int64_t kDisowned = 5000 * kMs;  // an authority is here but does not claim its body
constexpr std::int64_t kReturned = 2500 * kMs;  // the same, if that authority names us
constexpr std::int64_t kNextInLine = 2500 * kMs;  // longer for each peer in line before us

}  // namespace

void Ownership::Succeed() noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (body.claim.peer == 0 && body.free && !body.disputed && authority(b) == self_) {
      // a peer must move it
      body.claim = {1, self_};
      body.began_epoch = 1;
      body.claimed_ns = now_ns_;
    }
    if (body.claim.peer != 0 && body.claim.peer != self_) SucceedTo(b);
  }
}

void Ownership::SucceedTo(std::size_t b) noexcept {
  Body& body = bodies_[b];
  const Member* member = members_.Find(body.claim.peer);
  const bool here = member != nullptr && member->present && !body.forsaken;
  if (here) {
    const Claim* claim = ClaimOf(*member, body.index);
    if (claim != nullptr && claim->epoch >= body.claim.epoch) {
      body.orphaned_ns = 0;
      body.handed = false;
      body.passed_on = false;
      return;
    }
    // a cut may lose a hand-over, and a peer that gets a body unasked does not ask for it
    if (body.handed && now_ns_ - body.sent_ns >= kAskAgain) {
      body.sent_ns = now_ns_;
      QueueEvent(body.handed_by, b, body.claim.epoch, body.claim.peer);
    }
  }
  if (body.orphaned_ns == 0) body.orphaned_ns = now_ns_;
  std::int64_t turn = PeersBefore(b);
  const bool left = member != nullptr && member->left;
  // an unknown peer may have been granted the body by another
  const bool gone = member != nullptr && !here;
  if (gone && turn > 0 && !std::exchange(body.passed_on, true)) {
    // the granting peer may be gone too, before the peers in line have heard of the grant
    QueueEvent(EventKind::kGrant, b, body.claim.epoch, body.claim.peer);
  }
  // a claimant that says it is ours has not heard, or not believed, the grant
  const bool ours_by_it = here && !body.handed && NamedBy(*member, body.index) == self_;
  if (ours_by_it) turn = 0;
  const std::int64_t in_turn = ours_by_it ? kReturned : !gone ? kDisowned : left ? 0 : kLostWait;
  const std::int64_t wait = in_turn + turn * kNextInLine;
  // another peer here claims it, and we shall follow that claim
  const bool claimed = body.outdone_ns != 0;
  if (now_ns_ - body.orphaned_ns < wait || claimed) return;
  NoteBefore(body, body.forsaken);
  body.last_epoch = std::max(body.last_epoch, body.claim.epoch);
  body.claim = {Next(body.last_epoch), self_};
  body.began_epoch = body.claim.epoch;
  body.claimed_ns = now_ns_;
  body.orphaned_ns = 0;
  body.forsaken = false;
  body.by_word = false;
  body.handed = false;
  Notify(Notification::Kind::kInherited, b, 0);
}

std::int64_t Ownership::PeersBefore(std::size_t b) const noexcept {
  const Body& body = bodies_[b];
  // the holders of a shared body come first; in each group the lowest peer comes first
  const bool in_hands = body.shared && (held_ == static_cast<int>(b) || HeldByOther(b));
  const bool ours = held_ == static_cast<int>(b);
  std::int64_t turn = 0;
  for (const Member& other : members_) {
    if (!other.present || other.peer == body.claim.peer) continue;
    const PeerId named = NamedBy(other, body.index);
    // that peer leaves the body to us, unless it has not heard that we gave it away
    const bool has_not_heard = HadItRecently(body, self_) && IsStale(other, body, self_);
    if (named == self_ && !has_not_heard) continue;
    if (named == 0 && other.since_ns > body.claimed_ns) continue;  // it never heard of the claim
    const bool holds = in_hands && HeldBy(b, other.peer);
    if (holds != ours && in_hands ? holds : other.peer < self_) ++turn;
  }
  return turn;
}

}  // namespace tandem
