#include "tests/support/triangle_overlap.h"

#include <algorithm>
#include <cmath>

namespace tandem::testing {

namespace {

using Wide = TriangleOverlap::Wide;

Wide Dot(const std::array<Wide, 3>& n, const SnappedPoint& p) {
  return n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
}

SnappedPoint Difference(const SnappedPoint& a, const SnappedPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// n . (lowest corner of a cell) must lie strictly between two bounds for the cell to meet the
/// triangle's shadow on the axis n. Whole numbers: "at least t" is "above t - 1".
struct Slab {
  Wide value;                // at the block's first cell
  std::array<Wide, 3> step;  // from cell to cell
  Wide above;
  Wide below;

  bool Holds(Wide v) const { return v > above && v < below; }
};

Slab MakeSlab(const std::array<Wide, 3>& n, Wide least, Wide greatest, const SnappedPoint& corner,
              Wide side) {
  Wide rise = 0;  // rise of n . p from the box's lowest corner to its farthest along n
  Wide fall = 0;
  for (const Wide& component : n) (component > 0 ? rise : fall) += component * side;
  return {.value = Dot(n, corner),
          .step = {n[0] * side, n[1] * side, n[2] * side},
          .above = least - rise - (rise == 0 ? 1 : 0),
          .below = greatest - fall + (fall == 0 ? 1 : 0)};
}

}  // namespace

TriangleOverlap::TriangleOverlap(const SnappedTriangle& triangle) : first_(triangle[0]) {
  min_ = max_ = first_;
  for (std::size_t v = 1; v < 3; ++v) {
    for (std::size_t k = 0; k < 3; ++k) {
      min_[k] = std::min(min_[k], triangle[v][k]);
      max_[k] = std::max(max_[k], triangle[v][k]);
    }
  }
  const std::array<SnappedPoint, 3> from_first{SnappedPoint{}, Difference(triangle[1], first_),
                                               Difference(triangle[2], first_)};
  const SnappedPoint& a = from_first[1];
  const SnappedPoint& b = from_first[2];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3;
    const std::size_t j = (k + 2) % 3;
    normal_[k] = Wide{a[i]} * b[j] - Wide{a[j]} * b[i];
  }
  for (std::size_t e = 0; e < 3; ++e) {
    const SnappedPoint edge = Difference(from_first[(e + 1) % 3], from_first[e]);
    for (std::size_t k = 0; k < 3; ++k) {
      Axis& axis = edge_axes_[3 * e + k];
      axis.n[(k + 1) % 3] = edge[(k + 2) % 3];
      axis.n[(k + 2) % 3] = -edge[(k + 1) % 3];
      for (std::size_t v = 0; v < 3; ++v) {
        const Wide value = Dot({axis.n[0], axis.n[1], axis.n[2]}, from_first[v]);
        axis.least = v == 0 ? value : std::min(axis.least, value);
        axis.greatest = v == 0 ? value : std::max(axis.greatest, value);
      }
    }
  }
}

GridIndex TriangleOverlap::LowestCell(int side_bits) const {
  return {static_cast<std::int32_t>(min_[0] >> side_bits),
          static_cast<std::int32_t>(min_[1] >> side_bits),
          static_cast<std::int32_t>(min_[2] >> side_bits)};
}

GridIndex TriangleOverlap::HighestCell(int side_bits) const {
  return {static_cast<std::int32_t>(max_[0] >> side_bits),
          static_cast<std::int32_t>(max_[1] >> side_bits),
          static_cast<std::int32_t>(max_[2] >> side_bits)};
}

void TriangleOverlap::MarkBlock(const GridIndex& block, int side_bits,
                                std::array<std::uint64_t, 8>& cells) const {
  // the triangle's own box gives the cells to look at
  const GridIndex first = block * kChunkSide;
  const GridIndex lowest = LowestCell(side_bits) - first;
  const GridIndex highest = HighestCell(side_bits) - first;
  const int x0 = std::max(0, lowest.x);
  const int x1 = std::min(kChunkSide - 1, highest.x);
  const int y0 = std::max(0, lowest.y);
  const int y1 = std::min(kChunkSide - 1, highest.y);
  const int z0 = std::max(0, lowest.z);
  const int z1 = std::min(kChunkSide - 1, highest.z);
  if (x0 > x1 || y0 > y1 || z0 > z1) return;

  const auto corner_of = [side_bits](std::int32_t cell) {
    return std::int64_t{cell} << side_bits;
  };
  const SnappedPoint corner = Difference(
      {corner_of(first.x + x0), corner_of(first.y + y0), corner_of(first.z + z0)}, first_);
  const Wide side = Wide{1} << side_bits;
  std::array<Slab, 10> slabs{};
  slabs[0] = MakeSlab(normal_, 0, 0, corner, side);
  for (std::size_t a = 0; a < edge_axes_.size(); ++a) {
    const Axis& axis = edge_axes_[a];
    slabs[a + 1] =
        MakeSlab({axis.n[0], axis.n[1], axis.n[2]}, axis.least, axis.greatest, corner, side);
  }

  for (int z = z0; z <= z1; ++z) {
    for (int y = y0; y <= y1; ++y) {
      std::uint64_t row = 0;
      for (int x = x0; x <= x1; ++x) {
        bool meets = true;
        for (std::size_t a = 0; meets && a < slabs.size(); ++a) {
          const Slab& slab = slabs[a];
          meets = slab.Holds(slab.value + slab.step[0] * (x - x0) + slab.step[1] * (y - y0) +
                             slab.step[2] * (z - z0));
        }
        row |= std::uint64_t{meets} << x;
      }
      cells[static_cast<std::size_t>(z)] |= row << (8 * y);
    }
  }
}

}  // namespace tandem::testing
