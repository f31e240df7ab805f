// The excess of interpolated distances from place to place.
#include <algorithm>
#include <array>

#include "engine/field/query/distance_field.h"

namespace tandem {

float DistanceField::OverOfBrick(const GridIndex& brick) const noexcept {
  const GridIndex cells = size_ * kHyperbrickCells;
  const GridIndex cell = brick * kBrickCells;
  if (cell.x < 0 || cell.y < 0 || cell.z < 0 || cell.x >= cells.x || cell.y >= cells.y ||
      cell.z >= cells.z) {
    return 0;
  }
  const std::int32_t entry = EntryOf(cell);
  if (entry < 0) return 0;
  return bricks_[static_cast<std::size_t>(entry)].MostOver();
}

double DistanceField::OverAt(const Cell& cell) const {
  // Each corner of the place's brick has the greatest value of the bricks round it, so that no
  // place has less than its own brick. Between corners the value is interpolated.
  std::array<float, 27> of_bricks;
  const GridIndex brick = cell.cell >> 2;
  for (std::int32_t i = 0; i < 27; ++i) {
    of_bricks[static_cast<std::size_t>(i)] =
        OverOfBrick(brick + GridIndex{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1});
  }
  std::array<double, 8> corners{};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t at = (corner & 1) + (i & 1) + 3 * ((corner >> 1 & 1) + (i >> 1 & 1)) +
                             9 * ((corner >> 2) + (i >> 2));
      corners[corner] = std::max<double>(corners[corner], of_bricks[at]);
    }
  }
  const auto in_brick = [](std::int32_t cells, double rest) {
    return ((cells & (kBrickCells - 1)) + rest) / kBrickCells;
  };
  return InCube(corners,
                {in_brick(cell.cell.x, cell.from.x()), in_brick(cell.cell.y, cell.from.y()),
                 in_brick(cell.cell.z, cell.from.z())});
}

}  // namespace tandem
