#include "app/view/model/scene/peer_palette.h"

namespace tandem {

Colour PaletteColour(PersonColour number) {
  // in the order of NameOfColour()
  static constexpr std::array<Colour, kPersonColours> kColours{{{0.00F, 0.45F, 0.70F},
                                                                {0.75F, 0.25F, 0.60F},
                                                                {0.00F, 0.62F, 0.45F},
                                                                {0.84F, 0.37F, 0.00F},
                                                                {0.20F, 0.65F, 0.90F},
                                                                {0.90F, 0.62F, 0.00F},
                                                                {0.55F, 0.35F, 0.20F},
                                                                {0.45F, 0.45F, 0.45F}}};
  if (number == 0 || number > kColours.size()) return kColours.back();
  return kColours[number - 1U];
}

Colour ColourOfPerson(const PeerInfo& info) {
  return PaletteColour(ColourOf(info));
}

}  // namespace tandem
