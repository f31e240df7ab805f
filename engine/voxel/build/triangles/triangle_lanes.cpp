#include "engine/voxel/build/triangles/triangle_lanes.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/build/triangles/triangle_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

using Lanes = TriangleLanes;
using Marks = TriangleMarks;
using Flags = hn::Mask<D>;
constexpr std::size_t kPart = hn::MaxLanes(D());
static_assert(Lanes::kLanes % kPart == 0);
constexpr std::size_t kMostRows = Lanes::kMostRows;

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

/// Whole numbers below this, 2^52, stand in the lowest bits of their sum with it.
constexpr double kWholeBits = 4503599627370496.0;

/// The triangles of a part of the lanes, with what is the same in all of their rows. Lengths are in
/// voxels, places from the lowest corner of a triangle's box.
struct Triangles {
  std::array<Corner, 3> c;
  Corner size;    // size of the box
  Corner offset;  // place of the box in the block
  Corner n;       // normal
  std::array<Side, 3> xy, xz, yz;
  Flags by_plane;          // its plane bounds its rows
  Flags crosses;           // its crossings are wanted
  Doubles rise_y, rise_z;  // change of the plane's x along y and along z
  Doubles doubt, plane_doubt;
  Doubles beyond_x, beyond_y, last_x;
  bool any_plane;
};

/// The bounds of all rows with one y.
struct RowBounds {
  Interval x;
  Doubles plane_low, plane_high;  // contribution of y to the plane's x
};

/// The bounds of all rows with one z.
struct LayerBounds {
  Interval x;
  Interval y;
  Interval centres;               // rows y whose centres lie in the shadow along x
  Flags here;                     // the layer is in the box and in the block
  Doubles plane_low, plane_high;  // contribution of z to the plane's x
  Doubles plane_centre;
};

HWY_INLINE Flags InBlock(Doubles place) {
  const D d;
  return hn::And(hn::Ge(place, hn::Zero(d)), hn::Le(place, hn::Set(d, kHyperchunkSide - 1)));
}

HWY_INLINE void LoadTriangles(const Lanes& lanes, std::size_t part, Triangles& t) {
  const D d;
  const W w;
  const Doubles whole = hn::Set(d, kWholeBits);
  const Doubles unit = hn::Set(d, 1.0 / (1 << kSnapBits));
  for (std::size_t v = 0; v < 3; ++v) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto units = hn::Or(hn::Load(w, &lanes.p[v][k][part]), hn::BitCast(w, whole));
      t.c[v][k] = hn::Mul(unit, hn::Sub(hn::BitCast(d, units), whole));
    }
  }
  t.size = {hn::Load(d, &lanes.size[0][part]), hn::Load(d, &lanes.size[1][part]),
            hn::Load(d, &lanes.size[2][part])};
  t.offset = {hn::Load(d, &lanes.offset[0][part]), hn::Load(d, &lanes.offset[1][part]),
              hn::Load(d, &lanes.offset[2][part])};
  const auto& c = t.c;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = k == 2 ? 0 : k + 1;
    const std::size_t j = k == 0 ? 2 : k - 1;
    t.n[k] = hn::Sub(hn::Mul(hn::Sub(c[1][i], c[0][i]), hn::Sub(c[2][j], c[0][j])),
                     hn::Mul(hn::Sub(c[1][j], c[0][j]), hn::Sub(c[2][i], c[0][i])));
  }
  t.beyond_x = hn::Add(t.size[0], hn::Set(d, 1.5));
  t.beyond_y = hn::Add(t.size[1], hn::Set(d, 1.5));
  t.last_x = hn::Sub(t.size[0], hn::Set(d, 1.0));
}

HWY_INLINE void FindShadows(Triangles& t) {
  const Doubles zero = hn::Zero(D());
  FindSides(t.c, t.size, 0, 1, hn::Lt(t.n[2], zero), t.xy);
  FindSides(t.c, t.size, 0, 2, hn::Gt(t.n[1], zero), t.xz);
  FindSides(t.c, t.size, 1, 2, hn::Lt(t.n[0], zero), t.yz);
}

HWY_INLINE void FindPlanes(Doubles facing, Triangles& t) {
  const D d;
  const Doubles zero = hn::Zero(d);
  const Doubles one = hn::Set(d, 1.0);
  const Corner& n = t.n;
  const Corner& size = t.size;
  const Flags seen = hn::Ne(n[0], zero);  // along x
  t.by_plane = hn::And(seen, hn::And(hn::Ne(n[1], zero), hn::Ne(n[2], zero)));
  for (const Doubles& s : size) t.by_plane = hn::And(t.by_plane, hn::Gt(s, one));
  t.any_plane = !hn::AllFalse(d, t.by_plane);
  t.rise_y = hn::IfThenElseZero(seen, hn::Div(hn::Neg(n[1]), n[0]));
  t.rise_z = hn::IfThenElseZero(seen, hn::Div(hn::Neg(n[2]), n[0]));
  const Doubles extent = hn::Max(hn::Max(size[0], size[1]), size[2]);
  const Doubles little = hn::Set(d, 1e-14);
  t.doubt = hn::Mul(little, hn::Add(extent, one));
  t.plane_doubt =
      hn::Mul(little, hn::Add(hn::Add(extent, hn::Mul(hn::Abs(t.rise_y), hn::Add(size[1], one))),
                              hn::Mul(hn::Abs(t.rise_z), hn::Add(size[2], one))));
  t.crosses = hn::And(seen, hn::Ne(facing, zero));
}

HWY_INLINE void BoundRow(const Triangles& t, std::size_t y, RowBounds& bounds, Flags& doubtful) {
  const D d;
  const Doubles one = hn::Set(d, 1.0);
  const Doubles row = hn::Set(d, static_cast<double>(y));
  bounds.x = {hn::Zero(d), t.last_x};
  Narrow(t.xy, row, t.beyond_x, hn::Lt(row, t.size[1]), t.doubt, bounds.x, doubtful);
  if (!t.any_plane) return;
  const Doubles from = hn::Mul(t.rise_y, hn::Sub(row, t.c[0][1]));
  const Doubles to = hn::Mul(t.rise_y, hn::Sub(hn::Add(row, one), t.c[0][1]));
  const Flags up_y = hn::Gt(t.rise_y, hn::Zero(d));
  bounds.plane_high = hn::Add(t.c[0][0], hn::IfThenElse(up_y, to, from));
  bounds.plane_low = hn::Add(t.c[0][0], hn::IfThenElse(up_y, from, to));
}

/// Finds the rows of a layer whose centres lie in the shadow along x.
HWY_INLINE void FindCentres(const Triangles& t, Doubles height, Flags wanted, Interval& centres,
                            Flags& doubtful) {
  const D d;
  const Doubles half = hn::Set(d, 0.5);
  const Doubles one = hn::Set(d, 1.0);
  const auto& c = t.c;
  centres = {hn::Set(d, 1e9), hn::Set(d, -1e9)};
  for (std::size_t from = 0; from < 3; ++from) {
    const std::size_t to = from == 2 ? 0 : from + 1;
    const Flags spans = hn::And(hn::And(wanted, t.crosses),
                                hn::Xor(hn::Gt(c[from][2], height), hn::Gt(c[to][2], height)));
    const Doubles x =
        hn::Sub(hn::Add(c[from][1], hn::Mul(t.yz[from].slope, hn::Sub(height, c[from][2]))), half);
    const Doubles before = hn::Floor(x);
    doubtful = hn::Or(doubtful, hn::And(spans, NearWhole(x, before, t.doubt)));
    centres.low = hn::IfThenElse(spans, hn::Min(centres.low, hn::Add(before, one)), centres.low);
    centres.high = hn::IfThenElse(spans, hn::Max(centres.high, before), centres.high);
  }
}

HWY_INLINE void BoundLayer(const Triangles& t, std::size_t z, LayerBounds& bounds,
                           Flags& doubtful) {
  const D d;
  const Doubles zero = hn::Zero(d);
  const Doubles one = hn::Set(d, 1.0);
  const Doubles layer = hn::Set(d, static_cast<double>(z));
  const Flags wanted = hn::Lt(layer, t.size[2]);
  bounds.x = {zero, t.last_x};
  Narrow(t.xz, layer, t.beyond_x, wanted, t.doubt, bounds.x, doubtful);
  bounds.y = {zero, hn::Sub(t.size[1], one)};
  Narrow(t.yz, layer, t.beyond_y, wanted, t.doubt, bounds.y, doubtful);
  bounds.here = hn::And(wanted, InBlock(hn::Add(layer, t.offset[2])));

  const Doubles height = hn::Add(layer, hn::Set(d, 0.5));
  FindCentres(t, height, wanted, bounds.centres, doubtful);
  bounds.centres.low = hn::Max(bounds.centres.low, bounds.y.low);
  bounds.centres.high = hn::Min(bounds.centres.high, bounds.y.high);

  const Doubles lower_z = hn::Mul(t.rise_z, hn::Sub(layer, t.c[0][2]));
  const Doubles upper_z = hn::Mul(t.rise_z, hn::Sub(hn::Add(layer, one), t.c[0][2]));
  const Flags up_z = hn::Gt(t.rise_z, zero);
  bounds.plane_high = hn::IfThenElse(up_z, upper_z, lower_z);
  bounds.plane_low = hn::IfThenElse(up_z, lower_z, upper_z);
  bounds.plane_centre = hn::Mul(t.rise_z, hn::Sub(height, t.c[0][2]));
}

/// Narrows a row's interval to the cells that the plane meets.
HWY_INLINE void NarrowToPlane(const Triangles& t, const RowBounds& row, const LayerBounds& layer,
                              Interval& interval, Flags& met, Flags& doubtful) {
  const D d;
  const Doubles before = hn::Set(d, -1.5);
  const Doubles greatest =
      hn::Min(hn::Max(hn::Add(row.plane_high, layer.plane_high), before), t.beyond_x);
  const Doubles least =
      hn::Min(hn::Max(hn::Add(row.plane_low, layer.plane_low), before), t.beyond_x);
  const Doubles last = hn::Floor(greatest);
  const Doubles first = hn::Floor(least);
  doubtful = hn::Or(
      doubtful, hn::And(hn::And(met, t.by_plane), hn::Or(NearWhole(greatest, last, t.plane_doubt),
                                                         NearWhole(least, first, t.plane_doubt))));
  interval.high = hn::IfThenElse(t.by_plane, hn::Min(interval.high, last), interval.high);
  interval.low = hn::IfThenElse(t.by_plane, hn::Max(interval.low, first), interval.low);
  met = hn::And(met, hn::Le(interval.low, interval.high));
}

HWY_INLINE void StoreBits(const Triangles& t, const Interval& interval, Flags met,
                          std::uint64_t* to) {
  const D d;
  const W w;
  const Doubles whole = hn::Set(d, kWholeBits);
  const Doubles begin = hn::Max(hn::Zero(d), hn::Add(interval.low, t.offset[0]));
  const Doubles end = hn::Min(hn::Set(d, kHyperchunkSide - 1), hn::Add(interval.high, t.offset[0]));
  const auto low_bits = hn::Set(w, 63);
  const auto from = hn::And(hn::BitCast(w, hn::Add(begin, whole)), low_bits);
  const auto length = hn::BitCast(w, hn::Add(hn::Sub(end, begin), whole));
  const auto unused = hn::And(hn::Sub(low_bits, length), low_bits);
  const auto bits = hn::Shl(hn::Shr(hn::Set(w, ~std::uint64_t{0}), unused), from);
  const Flags marked = hn::And(met, hn::Le(begin, end));
  hn::Store(hn::IfThenElseZero(hn::RebindMask(w, marked), bits), w, to);
}

/// Notes the crossings of a row in `crossed`.
HWY_INLINE void StoreCrossings(const Triangles& t, Doubles row, const LayerBounds& layer,
                               const Interval& interval, Flags crossed, std::size_t part,
                               std::size_t i, Marks& out) {
  const D d;
  const Doubles half = hn::Set(d, 0.5);
  const Doubles one = hn::Set(d, 1.0);
  // the crossing lies in one of the row's cells, in spite of rounding
  const Doubles on_plane =
      hn::Add(hn::Add(t.c[0][0], hn::Mul(t.rise_y, hn::Sub(hn::Add(row, half), t.c[0][1]))),
              layer.plane_centre);
  const Doubles x = hn::Min(hn::Max(on_plane, interval.low), hn::Add(interval.high, one));
  const Doubles cell = hn::Min(interval.high, hn::Floor(x));
  const Doubles place = hn::Add(cell, t.offset[0]);
  crossed = hn::And(crossed, InBlock(place));
  const Doubles behind = hn::IfThenElseZero(hn::Gt(hn::Sub(x, cell), half), one);
  hn::Store(hn::Add(place, behind), d, &out.from[i][part]);
  out.crossed[i] = static_cast<std::uint8_t>(out.crossed[i] | MaskBits(d, crossed) << part);
}

/// Marks the row y of a layer, which is row `i` of the result.
HWY_INLINE void MarkRow(const Triangles& t, std::size_t y, const RowBounds& bounds,
                        const LayerBounds& layer, std::size_t part, std::size_t i, Marks& out,
                        Flags& doubtful) {
  const D d;
  const Doubles row = hn::Set(d, static_cast<double>(y));
  Interval interval{hn::Max(bounds.x.low, layer.x.low), hn::Min(bounds.x.high, layer.x.high)};
  Flags met = hn::And(hn::And(layer.here, hn::Le(interval.low, interval.high)),
                      hn::And(hn::Ge(row, layer.y.low), hn::Le(row, layer.y.high)));
  met = hn::And(met, InBlock(hn::Add(row, t.offset[1])));
  if (t.any_plane) NarrowToPlane(t, bounds, layer, interval, met, doubtful);
  StoreBits(t, interval, met, &out.bits[i][part]);
  const Flags crossed = hn::And(hn::And(met, t.crosses), hn::And(hn::Ge(row, layer.centres.low),
                                                                 hn::Le(row, layer.centres.high)));
  if (hn::AllFalse(d, crossed)) return;
  StoreCrossings(t, row, layer, interval, crossed, part, i, out);
}

void MarkPart(const Lanes& lanes, std::size_t part, Marks& out) {
  const D d;
  Triangles t;
  LoadTriangles(lanes, part, t);
  FindShadows(t);
  FindPlanes(hn::Load(d, &lanes.facing[part]), t);
  Flags doubtful = hn::And(t.by_plane, hn::Gt(t.plane_doubt, hn::Set(d, 0.25)));
  const auto rows_y = static_cast<std::size_t>(lanes.rows_y);
  const auto rows_z = static_cast<std::size_t>(lanes.rows_z);
  std::array<RowBounds, kMostRows> rows;
  for (std::size_t y = 0; y < rows_y; ++y) BoundRow(t, y, rows[y], doubtful);
  for (std::size_t z = 0; z < rows_z; ++z) {
    LayerBounds layer;
    BoundLayer(t, z, layer, doubtful);
    for (std::size_t y = 0; y < rows_y; ++y) {
      MarkRow(t, y, rows[y], layer, part, y + rows_y * z, out, doubtful);
    }
  }
  out.doubtful |= MaskBits(d, doubtful) << part;
  out.facing_x |= MaskBits(d, hn::Gt(t.n[0], hn::Zero(d))) << part;
}

void MarkParts(const Lanes& lanes, Marks& out) {
  out.doubtful = 0;
  out.facing_x = 0;
  std::fill_n(out.crossed.begin(), lanes.rows_y * lanes.rows_z, std::uint8_t{0});
  for (std::size_t part = 0; part < Lanes::kLanes; part += kPart) MarkPart(lanes, part, out);
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tandem {

namespace {

HWY_EXPORT(MarkParts);

}  // namespace

void MarkLanes(const TriangleLanes& lanes, TriangleMarks& out) {
  HWY_DYNAMIC_DISPATCH(MarkParts)(lanes, out);
}

}  // namespace tandem

#endif
