#include "app/view/model/scene/peer_palette.h"

namespace tandem {

Colour PeerPalette::ColourOf(PeerId peer) {
  static constexpr std::array<Colour, 8> kColours{{{0.00F, 0.45F, 0.70F},    // blue
                                                   {0.75F, 0.25F, 0.60F},    // purple
                                                   {0.00F, 0.62F, 0.45F},    // green
                                                   {0.84F, 0.37F, 0.00F},    // vermilion
                                                   {0.20F, 0.65F, 0.90F},    // sky
                                                   {0.90F, 0.62F, 0.00F},    // orange
                                                   {0.55F, 0.35F, 0.20F},    // brown
                                                   {0.45F, 0.45F, 0.45F}}};  // grey
  const auto [entry, is_new] = order_.try_emplace(peer, order_.size());
  return kColours.at(entry->second % kColours.size());
}

}  // namespace tandem
