#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "collab/ownership/ownership.h"
#include "tests/collab/ownership/ownership_cluster.h"

namespace tandem::testing {

inline constexpr PeerId kLiar = 77;

/// A peer that hears what a test says of the others; frames of 1 ms.
class Listener {
 public:
  using Kind = MembershipChange::Kind;

  explicit Listener(PeerId id, ObjectId object = kOwn)
      : ownership_(id, TwoBodies()), object_(object) {
    Run(1);
  }
  Ownership& ownership() { return ownership_; }
  void Run(int frames) {
    std::array<Event, 8> out;
    std::size_t count = 0;
    for (int i = 0; i < frames; ++i) {
      ownership_.Tick(now_ns_ += 1'000'000, out, count);
      stated_ += count;
    }
  }
  /// Returns how many events it has said.
  std::size_t stated() const { return stated_; }
  /// Hears `peer` say that it has the body, or which peer it names.
  void HearClaim(PeerId peer, std::uint32_t epoch, bool held, Kind kind = Kind::kClaims) {
    MembershipChange change{.kind = kind, .peer = peer, .claim_count = 1};
    change.claims[0] = {object_, epoch, held};
    ownership_.OnMembership(change);
  }
  void HearName(PeerId peer, PeerId named, std::uint32_t epoch, Kind kind = Kind::kClaims) {
    MembershipChange change{.kind = kind, .peer = peer, .belief_count = 1};
    change.beliefs[0] = {object_, named, epoch};
    ownership_.OnMembership(change);
  }
  void HearGone(PeerId peer, Kind kind) { ownership_.OnMembership({.kind = kind, .peer = peer}); }
  void HearGrant(PeerId from, PeerId to, std::uint32_t epoch) {
    Hear(EventKind::kGrant, from, to, epoch);
  }
  void Hear(EventKind kind, PeerId from, PeerId to, std::uint32_t epoch) {
    ownership_.OnEvent(
        {.peer = from, .kind = kind, .object = object_, .epoch = epoch, .to = to, .X_WB = {}});
  }

 private:
  Ownership ownership_;
  ObjectId object_;
  std::size_t stated_ = 0;
  std::int64_t now_ns_ = 1'000'000'000;
};

}  // namespace tandem::testing
