#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "collab/session/messages.h"

namespace tandem {

/// The number of a person's colour, 1 to kPersonColours, which is the same in all windows; 0: not
/// chosen yet. Each participant chooses its own colour and says it (PeerInfo::colour).
using PersonColour = std::uint8_t;
inline constexpr std::size_t kPersonColours = 8;

/// A participant that is here, as somebody else's choice takes it into account.
struct ColouredPerson {
  std::string name;
  Role role = Role::kActive;
  PersonColour colour = 0;
  bool before = false;  // it was here before the one that chooses
};

/// Returns the colour that a name has where nothing else is known. Equal names have equal colours.
PersonColour ColourOfName(const std::string& name);

/// Returns the colour that a participant says it has, or that of its name where it says none.
PersonColour ColourOf(const PeerInfo& info);

/// Returns the colour for a participant of this name and role. `now`: the colour that it has.
///
/// A person who takes part and looks on is one person with one colour. A colour that was chosen
/// stays, unless a person that came before has it too. A newcomer takes the colour of its name, or
/// the next one that nobody here has. If all are taken, it shares the one of its name.
PersonColour ChooseColour(const std::string& name, Role role, PersonColour now,
                          std::span<const ColouredPerson> others);

/// Returns whether the sender of `info` was here before the participant `self` with this beat. Both
/// sides of a pair find the same order.
bool CameBefore(const PeerInfo& info, PeerId self, std::uint32_t beat);

/// Returns "blue", "purple" and so on; empty for 0.
const char* NameOfColour(PersonColour colour);

}  // namespace tandem
