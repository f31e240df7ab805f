#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "collab/session/messages.h"

namespace tandem {

using Colour = std::array<float, 3>;  // red, green, blue, 0 to 1

/// Assigns a colour to each peer, in the order in which they are met, for the whole run. The
/// colours remain distinguishable with common colour blindness (Okabe and Ito). The
/// colours repeat after eight peers, so the peer table shows each peer's name beside its colour.
class PeerPalette {
 public:
  Colour ColourOf(PeerId peer);

 private:
  std::map<PeerId, std::size_t> order_;
};

}  // namespace tandem
