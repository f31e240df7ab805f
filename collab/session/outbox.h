#pragma once

#include <array>
#include <cstdint>

#include "collab/session/messages.h"

namespace tandem {

/// The output of a haptic frame; the sender thread takes the newest.
struct Outbox {
  std::uint32_t seq = 0;  // number of the frame
  bool holds = false;     // a body is in hand, and its state is to be sent
  ObjectState state;
  bool shared = false;  // links go with the state
  CouplingLinks links;
  bool is_loose = false;  // the next of the peer's loose bodies is to be sent
  ObjectState loose;
  ViewFrame view;
};

/// Claims and beliefs of a peer, for its peer_info.
struct ClaimList {
  std::uint32_t count = 0;
  std::array<Claim, kMaxClaims> claims{};
  std::uint32_t belief_count = 0;  // authorities of bodies of other peers
  std::array<Belief, kMaxClaims> beliefs{};
};

}  // namespace tandem
