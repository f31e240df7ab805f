#pragma once

#include <array>
#include <cstdint>

#include "collab/messages.h"

namespace tandem {

/// What the haptic thread must know of another active peer, when it changes. Handed over by value.
struct MembershipChange {
  static constexpr std::size_t kMaxHeld = 16;

  PeerId peer = 0;
  bool present = false;  // false: it left, or fell silent
  std::uint32_t held_count = 0;
  std::array<ObjectId, kMaxHeld> held{};
};

}  // namespace tandem
