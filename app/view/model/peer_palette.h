#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "collab/messages.h"

namespace tandem {

using Colour = std::array<float, 3>;  // red, green, blue, 0 to 1

/// A colour for each peer, in the order in which they are met; it stays while the program runs. The
/// colours can be told apart with the common kinds of colour blindness (Okabe and Ito), yet they
/// never stand alone: names go with them.
class PeerPalette {
 public:
  Colour Of(PeerId peer);

 private:
  std::map<PeerId, std::size_t> order_;
};

}  // namespace tandem
