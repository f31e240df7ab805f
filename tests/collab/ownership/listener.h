#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "collab/ownership/holdings.h"
#include "tests/collab/ownership/company.h"

namespace tandem::testing {

inline constexpr PeerId kLiar = 77;

/// A peer that hears what a test says of the others; frames of 1 ms.
class Listener {
 public:
  using Kind = MembershipChange::Kind;

  explicit Listener(PeerId id, ObjectId object = kOwn)
      : holdings_(id, TwoBodies()), object_(object) {
    Run(1);
  }
  Holdings& holdings() { return holdings_; }
  void Run(int frames) {
    std::array<Event, 8> out;
    std::size_t count = 0;
    for (int i = 0; i < frames; ++i) {
      holdings_.Tick(now_ns_ += 1'000'000, out, count);
      said_ += count;
    }
  }
  /// Returns how many events it has said.
  std::size_t said() const { return said_; }
  /// Hears `peer` say that it has the body, or which peer it names.
  void HearClaim(PeerId peer, std::uint32_t epoch, bool held, Kind kind = Kind::kClaims) {
    MembershipChange change{.kind = kind, .peer = peer, .claim_count = 1};
    change.claims[0] = {object_, epoch, held};
    holdings_.OnMembership(change);
  }
  void HearName(PeerId peer, PeerId named, std::uint32_t epoch, Kind kind = Kind::kClaims) {
    MembershipChange change{.kind = kind, .peer = peer, .belief_count = 1};
    change.beliefs[0] = {object_, named, epoch};
    holdings_.OnMembership(change);
  }
  void HearGone(PeerId peer, Kind kind) { holdings_.OnMembership({.kind = kind, .peer = peer}); }
  void HearGrant(PeerId from, PeerId to, std::uint32_t epoch) {
    Hear(EventKind::kGrant, from, to, epoch);
  }
  void Hear(EventKind kind, PeerId from, PeerId to, std::uint32_t epoch) {
    holdings_.OnEvent(
        {.peer = from, .kind = kind, .object = object_, .epoch = epoch, .to = to, .X_WB = {}});
  }

 private:
  Holdings holdings_;
  ObjectId object_;
  std::size_t said_ = 0;
  std::int64_t now_ns_ = 1'000'000'000;
};

}  // namespace tandem::testing
