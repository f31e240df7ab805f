#include "engine/voxel/build/triangles/triangle_rows.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/build/triangles/triangle_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

using View = TriangleRows::View;
using Flags = hn::Mask<D>;
constexpr std::size_t kPart = hn::MaxLanes(D());
static_assert(kPart <= TriangleRows::kPadding);
constexpr int kSide = kHyperchunkSide;
/// Values by row, with room for a vector that begins at the last one.
using ByRow = std::array<double, kSide + TriangleRows::kPadding>;

/// Returns first, first + 1, …
Doubles RowsFrom(std::int32_t first) {
  alignas(64) static constexpr std::array<double, 8> kCount{0, 1, 2, 3, 4, 5, 6, 7};
  const D d;
  return hn::Add(hn::Set(d, first), hn::Load(d, kCount.data()));
}

/// Tells whether x is within `doubt` of a whole number. `whole` is the greatest whole number that
/// is not above x.
Flags Doubtful(Doubles x, Doubles whole, double doubt) {
  const D d;
  const Doubles part = hn::Sub(x, whole);
  return hn::Or(hn::Lt(part, hn::Set(d, doubt)), hn::Gt(part, hn::Set(d, 1 - doubt)));
}

/// Replaces the lanes of `cells` that are in doubt by exact(row).
template <typename Exact>
Doubles Settle(Doubles cells, Flags doubtful, std::int32_t first_row, const Exact& exact) {
  const D d;
  if (hn::AllFalse(d, doubtful)) return cells;
  alignas(64) std::array<double, kPart> settled;
  alignas(64) std::array<double, kPart> in_doubt;
  hn::Store(cells, d, settled.data());
  hn::Store(hn::IfThenElseZero(doubtful, hn::Set(d, 1.0)), d, in_doubt.data());
  for (std::size_t i = 0; i < kPart; ++i) {
    if (in_doubt[i] != 0) settled[i] = exact(first_row + static_cast<std::int32_t>(i));
  }
  return hn::Load(d, settled.data());
}

/// Narrows [low, high] to the cells of rows first_row, first_row + 1, … that meet the shadow; rows
/// after last_row do not matter.
void Narrow(const View& t, const TriangleRows::Shadow& shadow, std::int32_t size_u,
            std::int32_t first_row, std::int32_t last_row, Doubles& low, Doubles& high) {
  const D d;
  const Doubles row = RowsFrom(first_row);
  const Flags wanted = hn::Le(row, hn::Set(d, last_row));
  for (std::size_t i = 0; i < shadow.count; ++i) {
    const TriangleRows::Bound& b = shadow.bounds[i];
    const Doubles at = hn::Add(row, hn::Set(d, b.farthest()));
    const Doubles line =
        hn::Add(hn::Set(d, b.u), hn::Mul(hn::Set(d, b.slope), hn::Sub(at, hn::Set(d, b.v))));
    // far off the exact place does not matter
    const Doubles x = hn::Min(hn::Max(line, hn::Set(d, -1.5)), hn::Set(d, size_u + 1.5));
    Doubles cells = hn::Floor(x);
    if (b.slope != 0) {
      const Flags doubtful = hn::And(wanted, Doubtful(x, cells, t.doubt));
      cells = Settle(cells, doubtful, first_row, [&](std::int32_t r) {
        return t.BoundCell(shadow, b, r);
      });
    }
    if (b.upper) {
      high = hn::Min(high, cells);
    } else {
      low = hn::Max(low, cells);
    }
  }
}

/// Finds the cells y whose centres lie in the shadow along x, for rows z from first_row on: [low,
/// high], or low above high.
void FindCentres(const View& t, std::int32_t first_row, std::int32_t last_row, Doubles& low,
                 Doubles& high) {
  const D d;
  const Doubles row = RowsFrom(first_row);
  const Doubles height = hn::Add(row, hn::Set(d, 0.5));
  const Flags wanted = hn::Le(row, hn::Set(d, last_row));
  low = hn::Set(d, 1e9);
  high = hn::Set(d, -1e9);
  for (std::size_t from = 0; from < 3; ++from) {
    const std::size_t to = from == 2 ? 0 : from + 1;
    const auto& a = t.c[from];
    const auto& b = t.c[to];
    if (a[2] == b[2]) continue;
    // the lower end belongs to a side, the upper does not
    const Flags spans = hn::And(
        wanted, hn::Xor(hn::Gt(hn::Set(d, a[2]), height), hn::Gt(hn::Set(d, b[2]), height)));
    if (hn::AllFalse(d, spans)) continue;
    const double slope = (b[1] - a[1]) / (b[2] - a[2]);
    const Doubles x = hn::Sub(
        hn::Add(hn::Set(d, a[1]), hn::Mul(hn::Set(d, slope), hn::Sub(height, hn::Set(d, a[2])))),
        hn::Set(d, 0.5));
    const Doubles whole = hn::Floor(x);
    const Flags doubtful = hn::And(spans, Doubtful(x, whole, t.doubt));
    const Doubles first =
        Settle(hn::Add(whole, hn::Set(d, 1.0)), doubtful, first_row, [&](std::int32_t r) {
          return t.CentreCell(from, to, r);
        });
    low = hn::IfThenElse(spans, hn::Min(low, first), low);
    high = hn::IfThenElse(spans, hn::Max(high, hn::Sub(first, hn::Set(d, 1.0))), high);
  }
}

/// Narrows [low, high] in rows y of one z by the plane.
void NarrowToPlane(const View& t, std::int32_t first_row, std::int32_t z, Flags wanted,
                   Doubles& low, Doubles& high) {
  const D d;
  const Doubles row = RowsFrom(first_row);
  const auto plane_at = [&](int plus_y, int plus_z) {
    const Doubles by_y = hn::Mul(hn::Set(d, t.rise_y),
                                 hn::Sub(hn::Add(row, hn::Set(d, plus_y)), hn::Set(d, t.c[0][1])));
    const double by_z = t.rise_z * (z + plus_z - t.c[0][2]);
    const Doubles x = hn::Add(hn::Add(hn::Set(d, t.c[0][0]), by_y), hn::Set(d, by_z));
    return hn::Min(hn::Max(x, hn::Set(d, -1.5)), hn::Set(d, t.size.x + 1.5));
  };
  const int up_y = t.rise_y > 0 ? 1 : 0;
  const int up_z = t.rise_z > 0 ? 1 : 0;
  const Doubles greatest = plane_at(up_y, up_z);
  const Doubles least = plane_at(1 - up_y, 1 - up_z);
  // a plane almost along x is left to whole numbers
  const double doubt = t.plane_doubt > 0.25 ? 2.0 : t.plane_doubt;
  const Doubles last = hn::Floor(greatest);
  const Doubles first = hn::Floor(least);
  high = hn::Min(high, Settle(last, hn::And(wanted, Doubtful(greatest, last, doubt)), first_row,
                              [&](std::int32_t y) {
                                return t.PlaneHigh(y, z);
                              }));
  low = hn::Max(low, Settle(first, hn::And(wanted, Doubtful(least, first, doubt)), first_row,
                            [&](std::int32_t y) {
                              return t.PlaneLow(y, z);
                            }));
}

/// The part of a triangle's box in a block: its rows, and the shadows' bounds of x and y in them.
struct RowBounds {
  std::int32_t y0, y1, z0, z1;                                    // first and last
  ByRow low_xy, high_xy;                                          // by y - y0
  ByRow low_xz, high_xz, low_y, high_y, low_centre, high_centre;  // by z - z0
};

HWY_INLINE void BoundRows(const View& t, bool crosses, RowBounds& b) {
  const D d;
  const Doubles last_x = hn::Set(d, t.size.x - 1);
  for (std::int32_t y = b.y0; y <= b.y1; y += kPart) {
    Doubles low = hn::Zero(d);
    Doubles high = last_x;
    Narrow(t, t.xy, t.size.x, y, b.y1, low, high);
    hn::StoreU(low, d, &b.low_xy[static_cast<std::size_t>(y - b.y0)]);
    hn::StoreU(high, d, &b.high_xy[static_cast<std::size_t>(y - b.y0)]);
  }
  for (std::int32_t z = b.z0; z <= b.z1; z += kPart) {
    const auto i = static_cast<std::size_t>(z - b.z0);
    Doubles low = hn::Zero(d);
    Doubles high = last_x;
    Narrow(t, t.xz, t.size.x, z, b.z1, low, high);
    hn::StoreU(low, d, &b.low_xz[i]);
    hn::StoreU(high, d, &b.high_xz[i]);
    low = hn::Set(d, b.y0);
    high = hn::Set(d, b.y1);
    Narrow(t, t.yz, t.size.y, z, b.z1, low, high);
    hn::StoreU(low, d, &b.low_y[i]);
    hn::StoreU(high, d, &b.high_y[i]);
    if (!crosses) continue;
    FindCentres(t, z, b.z1, low, high);
    hn::StoreU(low, d, &b.low_centre[i]);
    hn::StoreU(high, d, &b.high_centre[i]);
  }
}

/// The block to mark, with the place of the triangle's box in it.
struct Block {
  GridIndex offset;
  std::int32_t side;
  std::uint64_t* rows;
  int facing;
  std::vector<Crossing>* crossings;
};

/// The rows of a vector, from y on, and their cells [low, high].
struct Strip {
  std::int32_t y, z;
  std::size_t row;  // row of y in the block
  Doubles low, high;
};

/// Sets the bits of the cells of a strip in the rows that `met` names.
HWY_INLINE void SetBits(const Strip& strip, Flags met, const Block& block) {
  const D d;
  const W w;
  const Doubles shift_x = hn::Set(d, block.offset.x);
  const Doubles begin = hn::Max(hn::Zero(d), hn::Add(strip.low, shift_x));
  const Doubles end = hn::Min(hn::Set(d, block.side - 1), hn::Add(strip.high, shift_x));
  const Flags here = hn::And(met, hn::Le(begin, end));
  // whole numbers below 64 stand in the lowest bits of their sum with 2^52
  const Doubles whole = hn::Set(d, 4503599627370496.0);
  const auto low_bits = hn::Set(w, 63);
  const auto from = hn::And(hn::BitCast(w, hn::Add(begin, whole)), low_bits);
  const auto length = hn::BitCast(w, hn::Add(hn::Sub(end, begin), whole));
  const auto unused = hn::And(hn::Sub(low_bits, length), low_bits);
  const auto bits = hn::Shl(hn::Shr(hn::Set(w, ~std::uint64_t{0}), unused), from);
  std::uint64_t* rows = block.rows + strip.row;
  hn::StoreU(hn::Or(hn::LoadU(w, rows), hn::IfThenElseZero(hn::RebindMask(w, here), bits)), w,
             rows);
}

/// Lists the crossings of rows first..last of a strip.
HWY_INLINE void ListCrossings(const View& t, const Strip& strip, std::int32_t first,
                              std::int32_t last, const Block& block) {
  const D d;
  alignas(64) std::array<double, kPart> low_x;
  alignas(64) std::array<double, kPart> high_x;
  hn::Store(strip.low, d, low_x.data());
  hn::Store(strip.high, d, high_x.data());
  for (std::int32_t yy = first; yy <= last; ++yy) {
    const auto lane = static_cast<std::size_t>(yy - strip.y);
    if (low_x[lane] > high_x[lane]) continue;
    // the crossing lies in one of the row's cells, in spite of rounding
    const double x = std::clamp(
        t.c[0][0] + t.rise_y * (yy + 0.5 - t.c[0][1]) + t.rise_z * (strip.z + 0.5 - t.c[0][2]),
        low_x[lane], high_x[lane] + 1);
    const auto cell =
        std::min(static_cast<std::int32_t>(high_x[lane]), static_cast<std::int32_t>(x));
    const std::int32_t in_block = cell + block.offset.x;
    if (in_block < 0 || in_block >= block.side) continue;
    block.crossings->push_back(
        {.row = static_cast<std::uint16_t>(strip.row + lane),
         .from = static_cast<std::uint8_t>(in_block + (x - cell > 0.5 ? 1 : 0)),
         .entering = static_cast<std::int8_t>(-t.sense[0] * block.facing)});
  }
}

void MarkRows(const View& t, const Block& block) {
  const D d;
  const GridIndex& offset = block.offset;
  RowBounds b;
  b.y0 = std::max(0, -offset.y);
  b.y1 = std::min(t.size.y - 1, block.side - 1 - offset.y);
  b.z0 = std::max(0, -offset.z);
  b.z1 = std::min(t.size.z - 1, block.side - 1 - offset.z);
  const bool crosses = block.facing != 0 && t.sense[0] != 0;
  BoundRows(t, crosses, b);
  for (std::int32_t z = b.z0; z <= b.z1; ++z) {
    const auto iz = static_cast<std::size_t>(z - b.z0);
    if (b.low_xz[iz] > b.high_xz[iz] || b.low_y[iz] > b.high_y[iz]) continue;
    const auto end_y = static_cast<std::int32_t>(b.high_y[iz]);
    for (auto y = static_cast<std::int32_t>(b.low_y[iz]); y <= end_y; y += kPart) {
      const auto iy = static_cast<std::size_t>(y - b.y0);
      Strip strip{y, z, 0, hn::Max(hn::LoadU(d, &b.low_xy[iy]), hn::Set(d, b.low_xz[iz])),
                  hn::Min(hn::LoadU(d, &b.high_xy[iy]), hn::Set(d, b.high_xz[iz]))};
      Flags met = hn::And(hn::Le(RowsFrom(y), hn::Set(d, end_y)), hn::Le(strip.low, strip.high));
      if (t.by_plane) {
        NarrowToPlane(t, y, z, met, strip.low, strip.high);
        met = hn::And(met, hn::Le(strip.low, strip.high));
      }
      if (hn::AllFalse(d, met)) continue;
      strip.row = static_cast<std::size_t>(offset.y + y) +
                  static_cast<std::size_t>(block.side) * static_cast<std::size_t>(offset.z + z);
      SetBits(strip, met, block);
      if (!crosses || b.low_centre[iz] > b.high_centre[iz]) continue;
      const auto first = std::max(y, static_cast<std::int32_t>(b.low_centre[iz]));
      const auto last = std::min({y + static_cast<std::int32_t>(kPart) - 1, end_y,
                                  static_cast<std::int32_t>(b.high_centre[iz])});
      ListCrossings(t, strip, first, last, block);
    }
  }
}

void MarkTriangle(const View& t, const GridIndex& offset, std::int32_t side, std::uint64_t* rows,
                  int facing, std::vector<Crossing>* crossings) {
  MarkRows(t, {offset, side, rows, facing, crossings});
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tandem {

namespace {

HWY_EXPORT(MarkTriangle);

}  // namespace

void TriangleRows::Mark(const GridIndex& first, std::uint64_t* rows, int facing,
                        std::vector<Crossing>* crossings) const {
  MarkBlock(first, kHyperchunkSide, rows, facing, crossings);
}

void TriangleRows::MarkChunk(const GridIndex& chunk,
                             std::array<std::uint64_t, kChunkSide>& cells) const {
  alignas(64) std::array<std::uint64_t, kChunkSide * kChunkSide + kPadding> rows{};
  MarkBlock(chunk * kChunkSide, kChunkSide, rows.data(), 0, nullptr);
  for (std::size_t row = 0; row < kChunkSide * kChunkSide; ++row) {
    cells[row >> 3U] |= rows[row] << (8 * (row & 7U));
  }
}

void TriangleRows::MarkBlock(const GridIndex& first, std::int32_t side, std::uint64_t* rows,
                             int facing, std::vector<Crossing>* crossings) const {
  const GridIndex offset = lowest_ - first;  // place of the triangle's own cells in the block
  const GridIndex end = offset + view_.size;
  const auto apart = [side](std::int32_t begin, std::int32_t behind) {
    return begin >= side || behind <= 0;
  };
  if (apart(offset.x, end.x) || apart(offset.y, end.y) || apart(offset.z, end.z)) return;
  if (view_.whole_box) {
    const std::int32_t x0 = std::max(0, offset.x);
    const std::int32_t x1 = std::min(side, end.x) - 1;
    const std::uint64_t run = ~std::uint64_t{0} >> (63 - (x1 - x0)) << x0;
    for (std::int32_t z = std::max(0, offset.z); z < std::min(side, end.z); ++z) {
      for (std::int32_t y = std::max(0, offset.y); y < std::min(side, end.y); ++y) {
        rows[y + side * z] |= run;
      }
    }
    return;
  }
  HWY_DYNAMIC_DISPATCH(MarkTriangle)(view_, offset, side, rows, facing, crossings);
}

}  // namespace tandem

#endif
