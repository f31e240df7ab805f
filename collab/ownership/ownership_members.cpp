#include <algorithm>

#include "collab/ownership/ownership.h"

// Keeps who is in the session, and what each member claims and believes.

namespace tandem {

bool Ownership::IsHere(PeerId peer) const noexcept {
  const Member* member = members_.Find(peer);
  return member != nullptr && member->present;
}

int Ownership::CountHere() const noexcept {
  return static_cast<int>(std::ranges::count_if(members_, &Member::present));
}

Ownership::Member* Ownership::PlaceFor(PeerId peer) noexcept {
  if (Member* const place = members_.FindOrInsert(peer)) return place;
  PeerId gone = 0;
  for (const Member& member : members_) {
    if (!member.present) gone = member.peer;
  }
  members_.Erase(gone);
  return members_.FindOrInsert(peer);
}

void Ownership::OnMembership(const MembershipChange& change) noexcept {
  if (change.peer == 0 || change.peer == self_) return;
  const bool is_unknown = members_.Find(change.peer) == nullptr;
  if (is_unknown && !change.present()) return;
  Member* member = PlaceFor(change.peer);
  if (member == nullptr) return;  // more than a session may have
  const bool is_anew = !is_unknown && change.present() &&
                       (change.kind == MembershipChange::Kind::kJoined || member->left);
  if (is_unknown) member->known_ns = now_ns_;
  if (is_unknown || change.kind == MembershipChange::Kind::kJoined) {
    // The new peer does not know what the others have earned, so all counts begin anew. Epochs
    // already used beyond that stay used, or a peer that comes again and again would be believed
    // anything.
    own_epochs_ = std::max<std::int64_t>(0, own_epochs_ - EpochsSince(first_ns_) / 2);
    for (Member& other : members_) {
      other.epochs = std::max<std::int64_t>(0, other.epochs - EpochsSince(other.known_ns));
    }
    last_joined_ns_ = now_ns_;
  }
  // a peer that was started anew has been away, too
  const bool is_new = !member->present || (change.kind != MembershipChange::Kind::kClaims &&
                                           change.kind != MembershipChange::Kind::kBeliefs);
  if (is_new) {
    member->since_ns = now_ns_;  // or when it went
    member->held_before = -1;
    member->anew = is_anew;
  }
  member->present = change.present();
  member->left = change.kind == MembershipChange::Kind::kLeft;
  if (!change.present()) {
    // a peer that was here without claiming its body counts as gone from now on, as for all others
    for (Body& body : bodies_) {
      if (body.claim.peer == change.peer) body.orphaned_ns = 0;
    }
    return;
  }
  if (is_anew) BeginAnew(*member);
  Keep(change, *member);
  const int before = member->held_before;
  if (before >= 0 && !HeldBy(static_cast<std::size_t>(before), member->peer)) {
    member->held_before = -1;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (const Claim* const claim = ClaimOf(*member, b)) NoteClaim(b, *claim, *member);
  }
}

// The peer counts as having given away its bodies. Unlike a peer that was cut off, it does not come
// back with them, and its word on them is nobody's.
void Ownership::BeginAnew(Member& member) noexcept {
  for (Body& body : bodies_) {
    if (body.claim.peer == member.peer) body.forsaken = true;
    const auto absent = std::ranges::find(body.in_absence_of, member.peer);
    if (absent == body.in_absence_of.end()) continue;
    std::shift_left(absent, body.in_absence_of.end(), 1);
    body.in_absence_of.back() = 0;
    std::rotate(body.before.begin(), body.before.end() - 1, body.before.end());
    body.before[0] = {member.peer, now_ns_};
  }
}

// Sorted by body, since a dispute looks up all members. The first of two entries on one body
// counts.
void Ownership::Keep(const MembershipChange& change, Member& member) const noexcept {
  const auto keep = [this](const auto& stated, std::size_t count, auto& kept) {
    std::ranges::fill(kept, std::nullopt);
    for (std::size_t i = 0; i < std::min(count, stated.size()); ++i) {
      const int body = BodyOf(stated[i].object);
      if (body < 0 || body >= static_cast<int>(kept.size())) continue;
      auto& place = kept[static_cast<std::size_t>(body)];
      if (!place) place = stated[i];
    }
  };
  keep(change.claims, change.claim_count, member.claims);
  keep(change.beliefs, change.belief_count, member.beliefs);
}

}  // namespace tandem
