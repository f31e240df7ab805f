#pragma once

#include "engine/base/int128.h"
#include "engine/voxel/build/snapped_point.h"

namespace tandem::testing {

/// The oracle of TriangleRows tells whether one triangle meets half-open boxes [lowest, lowest +
/// side)^3, exactly, by separating axes in whole numbers (docs/decisions/0003-exact-voxels.md): a
/// voxel is surface if the closed triangle meets the half-open cell.
///
/// A half-open box is the union of the closed boxes [lowest, lowest + side - e] over e > 0, so on
/// each axis the comparison is strict exactly where the box's bound is not attained.
class TriangleOverlap {
 public:
  using Wide = Int128;

  explicit TriangleOverlap(const SnappedTriangle& triangle);

  /// Sets bits of `cells` (cell order of CellInBlock) for the cells of an 8 x 8 x 8 block that the
  /// triangle meets. The block's lowest corner is `block` * 8 cells of 2^side_bits snapped units
  /// each.
  void MarkBlock(const GridIndex& block, int side_bits, std::array<std::uint64_t, 8>& cells) const;

  /// Returns the lowest and highest cell, of 2^side_bits snapped units, that the triangle's own box
  /// meets.
  GridIndex LowestCell(int side_bits) const;
  GridIndex HighestCell(int side_bits) const;

 private:
  struct Axis {
    std::array<std::int64_t, 3> n;  // an edge crossed with a coordinate axis
    Wide least;                     // least n . vertex, relative to the first vertex
    Wide greatest;
  };

  SnappedPoint min_{};
  SnappedPoint max_{};
  SnappedPoint first_{};
  std::array<Axis, 9> edge_axes_{};
  std::array<Wide, 3> normal_{};  // the plane passes through first_: its shadow there is 0
};

}  // namespace tandem::testing
