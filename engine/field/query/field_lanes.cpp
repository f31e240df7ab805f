#include "engine/field/query/field_lanes.h"

#include <cstring>

#include "engine/field/query/field_brick.h"

namespace tandem {

namespace {

constexpr std::array<std::int32_t, 4> kEmptyBrick{};

std::int32_t EntryAt(const FieldView& field, std::int32_t hyperbrick, std::int32_t in_table) {
  if (hyperbrick < 0) return -1;
  const std::int32_t entry = field.hyperbricks[hyperbrick];
  if (entry < 0) return entry;
  const std::ptrdiff_t at = std::ptrdiff_t{entry} * kBricksPerHyperbrick + in_table;
  const std::int32_t brick = field.tables[at];
  return brick < 0 ? brick : static_cast<std::int32_t>(field.first_bricks[entry]) + brick;
}

/// Copies a vector of words.
void Copy(const std::uint8_t* from, const std::int32_t* bytes, std::int32_t* words) {
  std::array<std::int32_t, FieldLanes::kVector> read;
  for (std::size_t k = 0; k < FieldLanes::kVector; ++k) {
    std::memcpy(&read[k], from + bytes[k], sizeof(std::int32_t));
  }
  std::memcpy(words, read.data(), sizeof read);
}

}  // namespace

void ReadBricks(const FieldView& field, std::size_t count, FieldLanes& lanes) noexcept {
  for (std::size_t first = 0; first < count; first += FieldLanes::kVector) {
    bool near = false;
    for (std::size_t k = first; k < first + FieldLanes::kVector; ++k) {
      const std::int32_t entry = EntryAt(field, lanes.hyperbrick[k], lanes.in_table[k]);
      lanes.entry[k] = entry;
      near = near || entry >= 0;
      const std::int32_t* brick =
          entry < 0 ? kEmptyBrick.data() : field.bricks + 4 * std::ptrdiff_t{entry};
      std::memcpy(&lanes.bricks[4 * k], brick, sizeof(FieldBrick));
    }
    lanes.near[first / FieldLanes::kVector] = near;
  }
}

void ReadWords(const FieldView& field, std::size_t count, std::size_t words,
               FieldLanes& lanes) noexcept {
  for (std::size_t first = 0; first < count; first += FieldLanes::kVector) {
    if (!lanes.near[first / FieldLanes::kVector]) continue;
    for (std::size_t i = 0; i < words; ++i) {
      Copy(field.steps, &lanes.byte[i][first], &lanes.word[i][first]);
    }
  }
}

}  // namespace tandem
