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
  ViewFrame view;
};

/// What a peer answers for, for its peer_info.
struct ClaimList {
  std::uint32_t count = 0;
  std::array<Claim, kMaxClaims> claims{};
};

}  // namespace tandem
