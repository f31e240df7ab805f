#pragma once

#include <array>
#include <cstdint>

#include "collab/messages.h"

namespace tandem {

/// What a haptic frame has to say; the sender thread takes the newest.
struct Outbox {
  std::uint32_t seq = 0;  // of the frame
  bool holds = false;     // a body, whose state is to be sent
  ObjectState state;
  bool shared = false;  // links go with the state
  CouplingLinks links;
  bool is_loose = false;  // one of the loose bodies of the peer, the next in turn, is to be sent
  ObjectState loose;
  ViewFrame view;
};

/// What a peer answers for, for its peer_info.
struct ClaimList {
  std::uint32_t count = 0;
  std::array<Claim, kMaxClaims> claims{};
  std::uint32_t belief_count = 0;  // whom it takes for the authorities of the others
  std::array<Belief, kMaxClaims> beliefs{};
};

}  // namespace tandem
