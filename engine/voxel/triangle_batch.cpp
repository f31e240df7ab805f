#include "engine/voxel/triangle_batch.h"

#include <algorithm>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/triangle_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = TriangleBatch::Lanes;
using Marks = TriangleBatch::Marks;
using D = hn::CappedTag<double, TriangleBatch::kLanes>;
using U = hn::RebindToUnsigned<D>;
using Doubles = hn::Vec<D>;
using Flags = hn::Mask<D>;
constexpr std::size_t kPart = hn::MaxLanes(D());
constexpr std::size_t kMostRows = TriangleBatch::kMostRows;

using Corner = std::array<Doubles, 3>;

/// A side of a shadow on a plane (u, v), of a triangle in each lane. It bounds u in a row v.
struct Side {
  Doubles u, v, slope;
  Doubles ahead;  // 1 where the line reaches farthest out at the row's upper border
  Flags upper;
  Flags active;
  Flags slanted;  // and active
};

struct Interval {
  Doubles low, high;
};

Flags NearWhole(Doubles x, Doubles whole, Doubles doubt) {
  const D d;
  const Doubles part = hn::Sub(x, whole);
  return hn::Or(hn::Lt(part, doubt), hn::Gt(part, hn::Sub(hn::Set(d, 1.0), doubt)));
}

void FindSides(const std::array<Corner, 3>& c, const Corner& size, std::size_t u, std::size_t v,
               Flags turned, std::array<Side, 3>& sides) {
  const D d;
  const Doubles one = hn::Set(d, 1.0);
  const Doubles zero = hn::Zero(d);
  const Flags thick = hn::And(hn::Gt(size[u], one), hn::Gt(size[v], one));
  for (std::size_t from = 0; from < 3; ++from) {
    const std::size_t to = from == 2 ? 0 : from + 1;
    Side& side = sides[from];
    side.u = c[from][u];
    side.v = c[from][v];
    const Doubles dv = hn::Sub(c[to][v], c[from][v]);
    side.slope = hn::Div(hn::Sub(c[to][u], c[from][u]), dv);
    // a shadow seen edge on is one line, with some sides up and some down
    side.upper = hn::Xor(hn::Gt(dv, zero), turned);
    side.active = hn::And(thick, hn::Ne(dv, zero));
    side.slanted = hn::And(side.active, hn::Ne(side.slope, zero));
    const Doubles outward = hn::IfThenElse(side.upper, side.slope, hn::Neg(side.slope));
    side.ahead = hn::IfThenElseZero(hn::Gt(outward, zero), one);
  }
}

/// Narrows a row's interval to what the sides leave.
void Narrow(const std::array<Side, 3>& sides, Doubles row, Doubles beyond, Flags wanted,
            Doubles doubt, Interval& interval, Flags& doubtful) {
  const D d;
  const Doubles before = hn::Set(d, -1.5);
  for (const Side& side : sides) {
    const Doubles at = hn::Add(row, side.ahead);
    const Doubles line = hn::Add(side.u, hn::Mul(side.slope, hn::Sub(at, side.v)));
    // far off the exact place does not matter
    const Doubles x = hn::Min(hn::Max(line, before), beyond);
    const Doubles cells = hn::Floor(x);
    doubtful = hn::Or(doubtful, hn::And(hn::And(wanted, side.slanted), NearWhole(x, cells, doubt)));
    const Flags above = hn::And(side.active, side.upper);
    const Flags below = hn::AndNot(side.upper, side.active);
    interval.high = hn::IfThenElse(above, hn::Min(interval.high, cells), interval.high);
    interval.low = hn::IfThenElse(below, hn::Max(interval.low, cells), interval.low);
  }
}

void MarkPart(const Lanes& t, std::size_t part, Marks& out) {
  const D d;
  const U u;
  const Doubles zero = hn::Zero(d);
  const Doubles half = hn::Set(d, 0.5);
  const Doubles one = hn::Set(d, 1.0);
  // whole numbers below 2^52 stand in the lowest bits of their sum with 2^52
  const Doubles whole = hn::Set(d, 4503599627370496.0);
  const Doubles unit = hn::Set(d, 1.0 / (1 << kSnapBits));
  std::array<Corner, 3> c;
  for (std::size_t v = 0; v < 3; ++v) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto units = hn::Or(hn::Load(u, &t.p[v][k][part]), hn::BitCast(u, whole));
      c[v][k] = hn::Mul(unit, hn::Sub(hn::BitCast(d, units), whole));
    }
  }
  const Corner size{hn::Load(d, &t.size[0][part]), hn::Load(d, &t.size[1][part]),
                    hn::Load(d, &t.size[2][part])};
  Corner n;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = k == 2 ? 0 : k + 1;
    const std::size_t j = k == 0 ? 2 : k - 1;
    n[k] = hn::Sub(hn::Mul(hn::Sub(c[1][i], c[0][i]), hn::Sub(c[2][j], c[0][j])),
                   hn::Mul(hn::Sub(c[1][j], c[0][j]), hn::Sub(c[2][i], c[0][i])));
  }
  std::array<Side, 3> xy, xz, yz;
  FindSides(c, size, 0, 1, hn::Lt(n[2], zero), xy);
  FindSides(c, size, 0, 2, hn::Gt(n[1], zero), xz);
  FindSides(c, size, 1, 2, hn::Lt(n[0], zero), yz);

  const Flags seen = hn::Ne(n[0], zero);  // along x
  Flags by_plane = hn::And(seen, hn::And(hn::Ne(n[1], zero), hn::Ne(n[2], zero)));
  for (const Doubles& s : size) by_plane = hn::And(by_plane, hn::Gt(s, one));
  const Doubles rise_y = hn::IfThenElseZero(seen, hn::Div(hn::Neg(n[1]), n[0]));
  const Doubles rise_z = hn::IfThenElseZero(seen, hn::Div(hn::Neg(n[2]), n[0]));
  const Doubles extent = hn::Max(hn::Max(size[0], size[1]), size[2]);
  const Doubles little = hn::Set(d, 1e-14);
  const Doubles doubt = hn::Mul(little, hn::Add(extent, one));
  const Doubles plane_doubt =
      hn::Mul(little, hn::Add(hn::Add(extent, hn::Mul(hn::Abs(rise_y), hn::Add(size[1], one))),
                              hn::Mul(hn::Abs(rise_z), hn::Add(size[2], one))));
  const Flags crosses = hn::And(seen, hn::Ne(hn::Load(d, &t.facing[part]), zero));
  Flags doubtful = hn::And(by_plane, hn::Gt(plane_doubt, hn::Set(d, 0.25)));

  const Doubles beyond_x = hn::Add(size[0], hn::Set(d, 1.5));
  const Doubles beyond_y = hn::Add(size[1], hn::Set(d, 1.5));
  const Doubles last_x = hn::Sub(size[0], one);
  const Doubles offset_x = hn::Load(d, &t.offset[0][part]);
  const Doubles offset_y = hn::Load(d, &t.offset[1][part]);
  const Doubles offset_z = hn::Load(d, &t.offset[2][part]);
  const Doubles side_end = hn::Set(d, kHyperchunkSide - 1);
  const auto in_block = [&](Doubles place) {
    return hn::And(hn::Ge(place, zero), hn::Le(place, side_end));
  };

  const auto rows_y = static_cast<std::size_t>(t.rows_y);
  const auto rows_z = static_cast<std::size_t>(t.rows_z);
  std::array<Interval, kMostRows> by_y;
  std::array<Doubles, kMostRows> plane_low, plane_high;  // contribution of y to the plane's x
  const Flags up_y = hn::Gt(rise_y, zero);
  const Flags up_z = hn::Gt(rise_z, zero);
  const bool any_plane = !hn::AllFalse(d, by_plane);
  for (std::size_t y = 0; y < rows_y; ++y) {
    const Doubles row = hn::Set(d, static_cast<double>(y));
    by_y[y] = {zero, last_x};
    Narrow(xy, row, beyond_x, hn::Lt(row, size[1]), doubt, by_y[y], doubtful);
    if (!any_plane) continue;
    const Doubles from = hn::Mul(rise_y, hn::Sub(row, c[0][1]));
    const Doubles to = hn::Mul(rise_y, hn::Sub(hn::Add(row, one), c[0][1]));
    plane_high[y] = hn::Add(c[0][0], hn::IfThenElse(up_y, to, from));
    plane_low[y] = hn::Add(c[0][0], hn::IfThenElse(up_y, from, to));
  }
  for (std::size_t z = 0; z < rows_z; ++z) {
    const Doubles layer = hn::Set(d, static_cast<double>(z));
    const Flags wanted = hn::Lt(layer, size[2]);
    Interval by_z{zero, last_x};
    Narrow(xz, layer, beyond_x, wanted, doubt, by_z, doubtful);
    Interval of_y{zero, hn::Sub(size[1], one)};
    Narrow(yz, layer, beyond_y, wanted, doubt, of_y, doubtful);
    const Flags here = hn::And(wanted, in_block(hn::Add(layer, offset_z)));

    // the rows whose centres lie in the shadow along x
    const Doubles height = hn::Add(layer, half);
    Doubles low_centre = hn::Set(d, 1e9);
    Doubles high_centre = hn::Set(d, -1e9);
    for (std::size_t from = 0; from < 3; ++from) {
      const std::size_t to = from == 2 ? 0 : from + 1;
      const Flags spans = hn::And(hn::And(wanted, crosses),
                                  hn::Xor(hn::Gt(c[from][2], height), hn::Gt(c[to][2], height)));
      const Doubles x =
          hn::Sub(hn::Add(c[from][1], hn::Mul(yz[from].slope, hn::Sub(height, c[from][2]))), half);
      const Doubles before = hn::Floor(x);
      doubtful = hn::Or(doubtful, hn::And(spans, NearWhole(x, before, doubt)));
      low_centre = hn::IfThenElse(spans, hn::Min(low_centre, hn::Add(before, one)), low_centre);
      high_centre = hn::IfThenElse(spans, hn::Max(high_centre, before), high_centre);
    }
    low_centre = hn::Max(low_centre, of_y.low);
    high_centre = hn::Min(high_centre, of_y.high);

    const Doubles lower_z = hn::Mul(rise_z, hn::Sub(layer, c[0][2]));
    const Doubles upper_z = hn::Mul(rise_z, hn::Sub(hn::Add(layer, one), c[0][2]));
    const Doubles most_z = hn::IfThenElse(up_z, upper_z, lower_z);
    const Doubles least_z = hn::IfThenElse(up_z, lower_z, upper_z);
    const Doubles centre_z = hn::Mul(rise_z, hn::Sub(height, c[0][2]));
    for (std::size_t y = 0; y < rows_y; ++y) {
      const Doubles row = hn::Set(d, static_cast<double>(y));
      Doubles low = hn::Max(by_y[y].low, by_z.low);
      Doubles high = hn::Min(by_y[y].high, by_z.high);
      Flags met = hn::And(hn::And(here, hn::Le(low, high)),
                          hn::And(hn::Ge(row, of_y.low), hn::Le(row, of_y.high)));
      met = hn::And(met, in_block(hn::Add(row, offset_y)));
      if (any_plane) {
        const Doubles before = hn::Set(d, -1.5);
        const Doubles greatest = hn::Min(hn::Max(hn::Add(plane_high[y], most_z), before), beyond_x);
        const Doubles least = hn::Min(hn::Max(hn::Add(plane_low[y], least_z), before), beyond_x);
        const Doubles last = hn::Floor(greatest);
        const Doubles first = hn::Floor(least);
        doubtful = hn::Or(doubtful, hn::And(hn::And(met, by_plane),
                                            hn::Or(NearWhole(greatest, last, plane_doubt),
                                                   NearWhole(least, first, plane_doubt))));
        high = hn::IfThenElse(by_plane, hn::Min(high, last), high);
        low = hn::IfThenElse(by_plane, hn::Max(low, first), low);
        met = hn::And(met, hn::Le(low, high));
      }
      const Doubles begin = hn::Max(zero, hn::Add(low, offset_x));
      const Doubles end = hn::Min(side_end, hn::Add(high, offset_x));
      const auto low_bits = hn::Set(u, 63);
      const auto from = hn::And(hn::BitCast(u, hn::Add(begin, whole)), low_bits);
      const auto length = hn::BitCast(u, hn::Add(hn::Sub(end, begin), whole));
      const auto unused = hn::And(hn::Sub(low_bits, length), low_bits);
      const auto bits = hn::Shl(hn::Shr(hn::Set(u, ~std::uint64_t{0}), unused), from);
      const Flags marked = hn::And(met, hn::Le(begin, end));
      const std::size_t i = y + rows_y * z;
      hn::Store(hn::IfThenElseZero(hn::RebindMask(u, marked), bits), u, &out.bits[i][part]);

      Flags crossed = hn::And(hn::And(met, crosses),
                              hn::And(hn::Ge(row, low_centre), hn::Le(row, high_centre)));
      if (hn::AllFalse(d, crossed)) continue;
      // the crossing lies in one of the row's cells, in spite of rounding
      const Doubles on_plane = hn::Add(
          hn::Add(c[0][0], hn::Mul(rise_y, hn::Sub(hn::Add(row, half), c[0][1]))), centre_z);
      const Doubles x = hn::Min(hn::Max(on_plane, low), hn::Add(high, one));
      const Doubles cell = hn::Min(high, hn::Floor(x));
      const Doubles place = hn::Add(cell, offset_x);
      crossed = hn::And(crossed, in_block(place));
      const Doubles behind = hn::IfThenElseZero(hn::Gt(hn::Sub(x, cell), half), one);
      hn::Store(hn::Add(place, behind), d, &out.from[i][part]);
      std::array<std::uint8_t, 8> mask_bits{};
      hn::StoreMaskBits(d, crossed, mask_bits.data());
      out.crossed[i] = static_cast<std::uint8_t>(out.crossed[i] | mask_bits[0] << part);
    }
  }
  std::array<std::uint8_t, 8> mask_bits{};
  hn::StoreMaskBits(d, doubtful, mask_bits.data());
  out.doubtful |= static_cast<unsigned>(mask_bits[0]) << part;
  mask_bits = {};
  hn::StoreMaskBits(d, hn::Gt(n[0], zero), mask_bits.data());
  out.facing_x |= static_cast<unsigned>(mask_bits[0]) << part;
}

void MarkLanes(const Lanes& t, Marks& out) {
  out.doubtful = 0;
  out.facing_x = 0;
  std::fill_n(out.crossed.begin(), t.rows_y * t.rows_z, std::uint8_t{0});
  for (std::size_t part = 0; part < TriangleBatch::kLanes; part += kPart) MarkPart(t, part, out);
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tandem {

namespace {

HWY_EXPORT(MarkLanes);

}  // namespace

void TriangleBatch::Add(const SnappedPoint& a, const SnappedPoint& b, const SnappedPoint& c,
                        int facing) {
  std::array<std::int64_t, 3> low;
  std::array<std::int32_t, 3> size;
  std::array<std::int32_t, 3> offset;
  const std::array<std::int32_t, 3> first{first_.x, first_.y, first_.z};
  bool apart = false;
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = std::min({a[k], b[k], c[k]}) >> kSnapBits;
    size[k] = static_cast<std::int32_t>((std::max({a[k], b[k], c[k]}) >> kSnapBits) - low[k]) + 1;
    offset[k] = static_cast<std::int32_t>(low[k]) - first[k];
    apart = apart || offset[k] >= kHyperchunkSide || offset[k] + size[k] <= 0;
    low[k] <<= kSnapBits;
  }
  if (apart) return;
  const std::int32_t most = std::max(size[1], size[2]);
  if (most > kMostRows || size[0] > kHyperchunkSide / 2) {
    TriangleRows({a, b, c}, kSnapBits).Mark(first_, rows_, facing, crossings_);
    return;
  }
  // many triangles of a fine mesh are one voxel or a straight run, beside the centre lines
  const int thin = (size[0] == 1) + (size[1] == 1) + (size[2] == 1);
  if (thin >= 2) {
    const auto beside = [&](std::size_t k) {
      constexpr std::int64_t kHalf = std::int64_t{1} << (kSnapBits - 1);
      const std::int64_t middle = low[k] + kHalf;
      return (a[k] > middle && b[k] > middle && c[k] > middle) ||
             (a[k] < middle && b[k] < middle && c[k] < middle);
    };
    if (facing == 0 || (size[1] == 1 && beside(1)) || (size[2] == 1 && beside(2))) {
      const std::int32_t x0 = std::max(0, offset[0]);
      const std::int32_t x1 = std::min(kHyperchunkSide, offset[0] + size[0]) - 1;
      const std::uint64_t run = ~std::uint64_t{0} >> (63 - (x1 - x0)) << x0;
      const std::int32_t end_y = std::min(kHyperchunkSide, offset[1] + size[1]);
      const std::int32_t end_z = std::min(kHyperchunkSide, offset[2] + size[2]);
      for (std::int32_t z = std::max(0, offset[2]); z < end_z; ++z) {
        for (std::int32_t y = std::max(0, offset[1]); y < end_y; ++y) {
          rows_[y + kHyperchunkSide * z] |= run;
        }
      }
      return;
    }
  }
  Lanes& lanes = lanes_[most <= 2 ? 0 : (most <= 4 ? 1 : 2)];
  const std::size_t lane = lanes.count++;
  for (std::size_t k = 0; k < 3; ++k) {
    lanes.p[0][k][lane] = static_cast<std::uint64_t>(a[k] - low[k]);
    lanes.p[1][k][lane] = static_cast<std::uint64_t>(b[k] - low[k]);
    lanes.p[2][k][lane] = static_cast<std::uint64_t>(c[k] - low[k]);
    lanes.size[k][lane] = size[k];
    lanes.offset[k][lane] = offset[k];
  }
  lanes.facing[lane] = facing;
  lanes.row[lane] = static_cast<std::uint32_t>(offset[1] + kHyperchunkSide * offset[2]);
  lanes.corners[lane] = {&a, &b, &c};
  lanes.rows_y = std::max(lanes.rows_y, size[1]);
  lanes.rows_z = std::max(lanes.rows_z, size[2]);
  if (lanes.count == kLanes) Flush(lanes);
}

void TriangleBatch::Flush(Lanes& lanes) {
  for (std::size_t lane = lanes.count; lane < kLanes; ++lane) {
    for (auto& size : lanes.size) size[lane] = 0;  // nothing is met
  }
  HWY_DYNAMIC_DISPATCH(MarkLanes)(lanes, marks_);
  const auto rows_y = static_cast<std::size_t>(lanes.rows_y);
  const auto rows_z = static_cast<std::size_t>(lanes.rows_z);
  const unsigned used = (1U << lanes.count) - 1;
  const unsigned sure = used & ~marks_.doubtful;
  alignas(64) std::array<std::uint64_t, kLanes> kept;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    kept[lane] = (sure >> lane & 1U) != 0 ? ~std::uint64_t{0} : 0;
  }
  for (std::size_t z = 0; z < rows_z; ++z) {
    for (std::size_t y = 0; y < rows_y; ++y) {
      const std::size_t i = y + rows_y * z;
      const auto row = static_cast<std::uint32_t>(y + kHyperchunkSide * z);
      // a row outside the block has no bits, so it does not matter which row gets them
      for (std::size_t lane = 0; lane < lanes.count; ++lane) {
        rows_[(lanes.row[lane] + row) % kBrickRows] |= marks_.bits[i][lane] & kept[lane];
      }
      for (unsigned rest = marks_.crossed[i] & sure; rest != 0; rest &= rest - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
        const int facing = static_cast<int>(lanes.facing[lane]);
        crossings_->push_back(
            {.row = static_cast<std::uint16_t>((lanes.row[lane] + row) % kBrickRows),
             .from = static_cast<std::uint8_t>(marks_.from[i][lane]),
             .entering =
                 static_cast<std::int8_t>((marks_.facing_x >> lane & 1U) != 0 ? -facing : facing)});
      }
    }
  }
  for (unsigned rest = marks_.doubtful & used; rest != 0; rest &= rest - 1) {
    const auto& [a, b, c] = lanes.corners[static_cast<std::size_t>(std::countr_zero(rest))];
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    TriangleRows({*a, *b, *c}, kSnapBits)
        .Mark(first_, rows_, static_cast<int>(lanes.facing[lane]), crossings_);
  }
  lanes.count = 0;
  lanes.rows_y = 0;
  lanes.rows_z = 0;
}

void TriangleBatch::Finish() {
  for (Lanes& lanes : lanes_) {
    if (lanes.count > 0) Flush(lanes);
  }
}

}  // namespace tandem

#endif
