#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/field/build/near_faces.h"
#include "engine/field/query/field_brick.h"

namespace tandem {

// Parts of a field while it is built.

/// Cells that have a list, in rising order.
struct BuiltLists {
  std::uint64_t cells = 0;
  std::vector<std::uint8_t> shares;
  std::vector<std::uint8_t> overs;
  std::vector<std::vector<std::uint32_t>> faces;
};

struct BuiltBrick {
  std::size_t place = 0;  // in its hyperbrick, as CellInBlock
  PackedBrick packed;
  std::uint64_t in_band = 0;  // cells that the band reaches, none in a flat brick
  CellCandidates candidates;
  std::uint64_t erring = 0;
  std::array<float, kCellsPerBrick> over{};
  float outer_over = 0;  // the same where no cell is measured
  BuiltLists lists;
};

struct BuiltHyperbrick {
  std::vector<std::uint32_t> near;  // faces
  std::vector<BuiltBrick> bricks;
  /// Per place: number of a brick, or a bound's entry. Empty where `bound` holds throughout.
  std::vector<std::int32_t> entries;
  std::int32_t bound = 0;
  double within_band = 0;
  double beyond = 0;
};

}  // namespace tandem
