#pragma once

#include <array>

#include "collab/session/person_colour.h"

namespace tandem {

using Colour = std::array<float, 3>;  // red, green, blue, 0 to 1

/// Returns the colour with that number, 1 to kPersonColours; grey for others. The colours remain
/// distinguishable with common colour blindness (Okabe and Ito). They repeat after eight persons,
/// so the peer table shows each person's name beside its colour.
Colour PaletteColour(PersonColour number);

/// Returns the colour of a participant, which is the same in all windows.
Colour ColourOfPerson(const PeerInfo& info);

}  // namespace tandem
