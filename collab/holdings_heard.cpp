#include <algorithm>

#include "collab/holdings.h"
#include "collab/planted_faults.h"
#include "engine/base/units.h"

// What others say of who holds what, and what it makes of ours; holdings.cpp has our own wishes.

namespace tandem {

namespace {

constexpr std::uint32_t kMostEpochs = 1000;  // that one claim may run ahead of what we know,
constexpr std::int64_t kEpoch = 100 * kMs;   // and one more for each such time since we knew it
constexpr std::int64_t kTellAgain = 2000 * kMs;
constexpr std::int64_t kWithdrawn = 5000 * kMs;  // that a grant of it may be on its way

}  // namespace

void Holdings::Note(std::size_t index, std::uint32_t epoch, PeerId peer,
                    bool in_its_hand) noexcept {
  Body& body = bodies_[index];
  if (!Greater(epoch, peer, body)) return;
  // one that nobody can have come to by grabbing, in the time since, is a fault or an attack
  const std::int64_t most = kMostEpochs + (now_ns_ - body.noted_ns) / kEpoch;
  if (body.claim.peer != 0 && epoch - body.claim.epoch > most) return;
  if (held_ == static_cast<int>(index) && body.claim.peer == self_) hold_epoch_ = body.claim.epoch;
  body.claim = {epoch, peer};
  body.noted_ns = now_ns_;
  body.orphaned_ns = 0;
  body.handed = false;
  body.passed_on = false;
  if (held_ != static_cast<int>(index) || body.shared || peer == self_) return;
  if (Planted(Fault::kHandsKept)) return;
  // another part of the session went on without us, or took it while we were stopped
  held_ = -1;
  Tell(HoldingNews::Kind::kTaken, index, peer);
  if (!in_its_hand) Ask(body.object);
}

Holdings::Member* Holdings::PlaceFor(PeerId peer) noexcept {
  // its own; else a free one; else that of somebody who is gone
  Member* best = nullptr;
  for (Member& place : members_) {
    if (place.peer == peer) return &place;
    if (place.present || (best != nullptr && best->peer == 0)) continue;
    best = &place;
  }
  return best;
}

void Holdings::OnMembership(const MembershipChange& change) noexcept {
  if (change.peer == 0 || change.peer == self_) return;
  if (!change.present() && Find(change.peer) == nullptr) return;
  Member* member = PlaceFor(change.peer);
  if (member == nullptr) return;  // more than a session may have
  member->peer = change.peer;
  member->present = change.present();
  member->left = change.kind == MembershipChange::Kind::kLeft;
  if (!change.present()) {
    // who did not answer for its body while it was here is gone only from now on, as for all others
    for (Body& body : bodies_) {
      if (body.claim.peer == change.peer) body.orphaned_ns = 0;
    }
    return;
  }
  member->claim_count = std::min<std::uint32_t>(change.claim_count, kMaxClaims);
  member->claims = change.claims;
  for (std::uint32_t i = 0; i < member->claim_count; ++i) {
    const Claim& claim = member->claims[i];
    const int body = BodyOf(claim.object);
    if (body >= 0 && claim.epoch > 0) {
      Note(static_cast<std::size_t>(body), claim.epoch, change.peer, claim.held);
    }
  }
}

void Holdings::OnEvent(const Event& event) noexcept {
  const int found = BodyOf(event.object);
  if (found < 0 || event.peer == self_ || event.peer == 0) return;
  const auto index = static_cast<std::size_t>(found);
  Body& body = bodies_[index];
  switch (event.kind) {
    case EventKind::kAsk:
      if (event.to == self_) OnAsk(index, event.peer);
      return;
    case EventKind::kGrant:
      OnGrant(index, event);
      return;
    case EventKind::kRefuse:
      if (event.to != self_ || wanted_ != found) return;
      wanted_ = -1;
      Tell(HoldingNews::Kind::kRefused, index, event.peer);
      return;
    case EventKind::kRelease:
      if (Planted(Fault::kLostRelease)) return;
      if (event.to != 0) {
        OnGrant(index, event);
      } else if (event.peer == body.claim.peer && event.epoch == body.claim.epoch) {
        body.parked = event.X_WB;
        body.told = true;
      }
      return;
    case EventKind::kHeal:
      return;
  }
}

void Holdings::OnAsk(std::size_t index, PeerId from) noexcept {
  const Body& body = bodies_[index];
  if (body.claim.peer == from) {
    // our grant of it has not reached the asker
    Say(EventKind::kGrant, index, body.claim.epoch, from);
    return;
  }
  if (authority(index) != self_ || listening()) return;
  if (body.shared && (held_ == static_cast<int>(index) || HeldByOther(index))) return;
  if (held_ == static_cast<int>(index) && !Planted(Fault::kHeldGranted)) {
    Say(EventKind::kRefuse, index, body.claim.epoch, from);
    TellAsked(index, from);
    return;
  }
  HandOver(index, EventKind::kGrant, from);
}

void Holdings::TellAsked(std::size_t index, PeerId from) noexcept {
  const ObjectId object = bodies_[index].object;
  const auto known = std::ranges::find(askers_, from, &Asker::peer);
  const bool is_known = known != askers_.end();
  if (is_known && known->object == object && now_ns_ - known->told_ns < kTellAgain) return;
  // a new one takes a free place, or that of whoever asked longest ago
  const auto place = is_known ? known : std::ranges::min_element(askers_, {}, &Asker::told_ns);
  *place = {from, object, now_ns_};
  Tell(HoldingNews::Kind::kAsked, index, from);
}

void Holdings::HandOver(std::size_t index, EventKind kind, PeerId to) noexcept {
  Body& body = bodies_[index];
  body.claim = {body.claim.epoch + 1, to};
  body.parked = body.X_WB;
  body.told = kind == EventKind::kRelease;
  body.orphaned_ns = 0;
  body.handed = true;
  body.handed_by = kind;
  body.said_ns = now_ns_;
  Say(kind, index, body.claim.epoch, to);
  if (Planted(Fault::kGrantKept)) body.claim.peer = self_;
}

void Holdings::OnGrant(std::size_t index, const Event& event) noexcept {
  if (event.to == 0) return;
  Body& body = bodies_[index];
  const bool known = body.claim.epoch == event.epoch && body.claim.peer == event.to;
  if (!known) Note(index, event.epoch, event.to, event.kind == EventKind::kGrant);
  if (body.claim.peer != event.to || body.claim.epoch != event.epoch) return;
  if (known) return;
  // what is granted to another is about to move
  body.parked = event.X_WB;
  body.told = event.to == self_ || event.kind == EventKind::kRelease;
  if (event.to != self_) return;
  const int b = static_cast<int>(index);
  // one that is put into our hand unasked is taken if the hand is empty; what was asked for and is
  // not wanted any more is not unasked
  const bool withdrawn = body.withdrawn_ns != 0 && now_ns_ - body.withdrawn_ns < kWithdrawn;
  const bool given = event.kind == EventKind::kGrant && held_ < 0 && wanted_ < 0 && !withdrawn &&
                     !stopped_ && !(own_only_ && body.shared);
  if (wanted_ == b || given) TakeInHand(index);
}

void Holdings::OnState(const ObjectState& state) noexcept {
  const int found = BodyOf(state.object);
  if (found < 0) return;
  Body& body = bodies_[static_cast<std::size_t>(found)];
  body.parked = state.X_WB;
  body.told = (state.flags & kStateParked) != 0;
}

}  // namespace tandem
