#pragma once

#include <array>
#include <cstdint>

#include "collab/session/messages.h"

namespace tandem {

/// News about another active peer for the haptic thread. Passed by value.
struct MembershipChange {
  /// kBeliefs: the peer's claims are unchanged, so nothing changes for its bodies.
  enum class Kind : std::uint8_t { kJoined, kLeft, kLost, kBack, kClaims, kBeliefs };

  Kind kind = Kind::kJoined;
  PeerId peer = 0;
  std::uint32_t claim_count = 0;  // all its claims
  std::array<Claim, kMaxClaims> claims{};
  std::uint32_t belief_count = 0;  // its authorities of other bodies
  std::array<Belief, kMaxClaims> beliefs{};

  bool present() const noexcept { return kind != Kind::kLeft && kind != Kind::kLost; }
  /// Returns its claim on a body that it has in hand; null: it is not here, or does not hold the
  /// body.
  const Claim* HeldClaim(ObjectId object) const noexcept {
    for (std::uint32_t i = 0; present() && i < claim_count; ++i) {
      if (claims[i].object == object && claims[i].held) return &claims[i];
    }
    return nullptr;
  }
  bool Holds(ObjectId object) const noexcept { return HeldClaim(object) != nullptr; }
};

}  // namespace tandem
