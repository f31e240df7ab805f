#include "collab/session/person_colour.h"

#include <algorithm>
#include <array>

namespace tandem {

PersonColour ColourOfName(const std::string& name) {
  // FNV-1a: the same on every machine and in every version
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char letter : name) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211ULL;
  }
  return static_cast<PersonColour>(1 + (hash ^ (hash >> 32U)) % kPersonColours);
}

PersonColour ColourOf(const PeerInfo& info) {
  return info.colour != 0 ? info.colour : ColourOfName(info.name);
}

PersonColour ChooseColour(const std::string& name, Role role, PersonColour now,
                          std::span<const ColouredPerson> others) {
  const auto is_same_person = [&](const ColouredPerson& other) {
    return other.name == name && other.role != role;
  };
  const auto itself = std::ranges::find_if(others, [&](const ColouredPerson& other) {
    return is_same_person(other) && other.before && other.colour != 0;
  });
  if (itself != others.end()) return itself->colour;
  const auto taken = [&](PersonColour colour, bool by_any) {
    return std::ranges::any_of(others, [&](const ColouredPerson& other) {
      return !is_same_person(other) && other.colour == colour && (by_any || other.before);
    });
  };
  if (now != 0 && !taken(now, false)) return now;
  const PersonColour first = ColourOfName(name);
  for (std::size_t i = 0; i < kPersonColours; ++i) {
    const auto colour = static_cast<PersonColour>(1 + (first - 1U + i) % kPersonColours);
    if (!taken(colour, true)) return colour;
  }
  return now != 0 ? now : first;
}

bool CameBefore(const PeerInfo& info, PeerId self, std::uint32_t beat) {
  // the beat was on its way for a while, and ours has gone on
  const std::int64_t ahead = std::int64_t{info.beat} - std::int64_t{beat};
  return ahead > 1 || (ahead >= -1 && info.peer < self);
}

const char* NameOfColour(PersonColour colour) {
  constexpr std::array<const char*, kPersonColours + 1> kNames{
      "", "blue", "purple", "green", "vermilion", "sky blue", "orange", "brown", "grey"};
  return colour < kNames.size() ? kNames[colour] : "";
}

}  // namespace tandem
