// Vectors of FieldLanes, for each instruction set. Included by files that foreach_target.h includes
// again.
#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/field/query/distance_field.h"
#include "engine/field/query/field_brick.h"
#include "engine/field/query/field_lanes.h"

#if defined(TANDEM_FIELD_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TANDEM_FIELD_LANES_INL_H
#undef TANDEM_FIELD_LANES_INL_H
#else
#define TANDEM_FIELD_LANES_INL_H
#endif

#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

constexpr std::size_t kWidth = hn::MaxLanes(F());  // lanes of a vector

HWY_INLINE Floats Lerp(Floats low, Floats high, Floats share) {
  return hn::Add(low, hn::Mul(share, hn::Sub(high, low)));
}

/// Returns the low `bits` of each lane as a signed number.
template <int kBits>
HWY_INLINE Ints SignedLow(Ints lanes) {
  return hn::ShiftRight<32 - kBits>(hn::ShiftLeft<32 - kBits>(lanes));
}

/// Stores where the bricks of cells of the lattice stand in the tables, for lanes from `at` on.
HWY_INLINE void StoreTablePlaces(const FieldView& field, const IntLanes3& cell, std::size_t at,
                                 FieldLanes& lanes) {
  const I i;
  const Ints below_zero = hn::Set(i, -1);
  const auto holds = [&](Ints along, std::int32_t size) HWY_ATTR {
    return hn::And(hn::Gt(along, below_zero), hn::Lt(along, hn::Set(i, size)));
  };
  const auto inside = hn::And(holds(cell.x, field.cells.x),
                              hn::And(holds(cell.y, field.cells.y), holds(cell.z, field.cells.z)));
  const Ints hyperbrick = hn::Add(
      hn::ShiftRight<5>(cell.x),
      hn::Mul(hn::Set(i, field.hyperbricks_x),
              hn::Add(hn::ShiftRight<5>(cell.y),
                      hn::Mul(hn::Set(i, field.hyperbricks_y), hn::ShiftRight<5>(cell.z)))));
  hn::StoreU(hn::IfThenElse(inside, hyperbrick, below_zero), i, &lanes.hyperbrick[at]);
  const Ints seven = hn::Set(i, 7);
  const Ints in_table =
      hn::Add(hn::And(hn::ShiftRight<2>(cell.x), seven),
              hn::Add(hn::ShiftLeft<3>(hn::And(hn::ShiftRight<2>(cell.y), seven)),
                      hn::ShiftLeft<6>(hn::And(hn::ShiftRight<2>(cell.z), seven))));
  hn::StoreU(in_table, i, &lanes.in_table[at]);
}

/// A vector of bricks.
struct Bricks {
  Floats mean;
  IntLanes3 slopes;
  Ints bits, over_of_lists, flags, steps;
};

HWY_INLINE Bricks LoadBricks(const FieldLanes& lanes, std::size_t at) {
  const F f;
  const I i;
  Ints mean;
  Ints slopes;
  Ints last;
  Ints steps;
  hn::LoadInterleaved4(i, &lanes.bricks[4 * at], mean, slopes, last, steps);
  return {hn::BitCast(f, mean),
          {SignedLow<16>(slopes), hn::ShiftRight<16>(slopes), SignedLow<16>(last)},
          hn::And(hn::ShiftRight<16>(last), hn::Set(i, 15)),
          hn::And(hn::ShiftRight<20>(last), hn::Set(i, 15)),
          hn::And(hn::ShiftRight<24>(last), hn::Set(i, 0xff)),
          steps};
}

/// Returns the value of bricks' planes at a place relative to their lowest nodes.
HWY_INLINE Floats PlaneAt(const Bricks& brick, const Lanes3& place) {
  const F f;
  const Floats risen = Dot(ToFloats(brick.slopes), place);
  return hn::Add(brick.mean, hn::Mul(hn::Set(f, FieldBrick::kSlope), risen));
}

/// Returns a step in voxels, 0 in a flat brick.
HWY_INLINE Floats StepOf(Ints bits, Ints flags) {
  const F f;
  const I i;
  const auto large = hn::Ne(hn::And(flags, hn::Set(i, FieldBrick::kLargeSteps)), hn::Zero(i));
  const auto flat = hn::Eq(bits, hn::Zero(i));
  const Floats step = hn::IfThenElse(hn::RebindMask(f, large), hn::Set(f, 2 * FieldBrick::kStep),
                                     hn::Set(f, FieldBrick::kStep));
  return hn::IfThenZeroElse(hn::RebindMask(f, flat), step);
}

/// Rows of two nodes along x: the number of the lower node, relative to the first row's.
inline constexpr std::array<int, 4> kRowNodes{0, 5, 25, 30};

/// Returns where the bits of rows of nodes begin, from where those of the first row do.
HWY_INLINE std::array<Ints, 4> RowBits(Ints bits, Ints first) {
  const Ints five = hn::Add(bits, hn::ShiftLeft<2>(bits));
  const Ints twenty_five = hn::Add(five, hn::ShiftLeft<2>(five));
  const Ints upper = hn::Add(first, twenty_five);
  return {first, hn::Add(first, five), upper, hn::Add(upper, five)};
}

/// The steps of two nodes.
struct RowSteps {
  Floats low, high;
};
HWY_INLINE RowSteps StepsOfRow(Ints bits, Ints first_bit, Ints word) {
  const F f;
  const I i;
  const Ints unused = hn::Sub(hn::Set(i, 32), bits);
  const Ints left = hn::Sub(unused, hn::And(first_bit, hn::Set(i, 7)));
  return {hn::ConvertTo(f, hn::Shr(hn::Shl(word, left), unused)),
          hn::ConvertTo(f, hn::Shr(hn::Shl(word, hn::Sub(left, bits)), unused))};
}

/// Returns the places in their cells.
HWY_INLINE Lanes3 FromCell(const FieldLanes& lanes, std::size_t at) {
  const F f;
  return {hn::LoadU(f, &lanes.x[at]), hn::LoadU(f, &lanes.y[at]), hn::LoadU(f, &lanes.z[at])};
}

HWY_INLINE IntLanes3 CellsAt(const FieldLanes& lanes, std::size_t at) {
  const I i;
  return {hn::LoadU(i, &lanes.cell_x[at]), hn::LoadU(i, &lanes.cell_y[at]),
          hn::LoadU(i, &lanes.cell_z[at])};
}

/// Returns the places of cells in their bricks.
HWY_INLINE IntLanes3 InBricks(const FieldLanes& lanes, std::size_t at) {
  const Ints three = hn::Set(I(), 3);
  const IntLanes3 cell = CellsAt(lanes, at);
  return {hn::And(cell.x, three), hn::And(cell.y, three), hn::And(cell.z, three)};
}

/// Returns x + 5 y + 25 z.
HWY_INLINE Ints NodeOf(const IntLanes3& in_brick) {
  const Ints zy = hn::Add(in_brick.y, hn::Add(in_brick.z, hn::ShiftLeft<2>(in_brick.z)));
  return hn::Add(in_brick.x, hn::Add(zy, hn::ShiftLeft<2>(zy)));
}

/// Unpacks the bricks of a vector of lanes, from `at` on, and finds where their data are.
HWY_INLINE void Unpack(std::size_t at, FieldLanes& lanes) {
  const F f;
  const I i;
  const Bricks brick = LoadBricks(lanes, at);
  const IntLanes3 in_brick = InBricks(lanes, at);
  const Lanes3 lowest = ToFloats(in_brick);
  const Lanes3 from = FromCell(lanes, at);
  const Lanes3 place{hn::Add(lowest.x, from.x), hn::Add(lowest.y, from.y),
                     hn::Add(lowest.z, from.z)};
  hn::StoreU(PlaneAt(brick, place), f, &lanes.plane[at]);
  hn::StoreU(brick.bits, i, &lanes.bits[at]);
  hn::StoreU(brick.flags, i, &lanes.flags[at]);
  hn::StoreU(brick.over_of_lists, i, &lanes.over_of_lists[at]);
  const Ints first_bit = hn::Mul(NodeOf(in_brick), brick.bits);
  hn::StoreU(first_bit, i, &lanes.first_bit[at]);
  const std::array<Ints, 4> bit = RowBits(brick.bits, first_bit);
  for (std::size_t row = 0; row < 4; ++row) {
    hn::StoreU(hn::Add(brick.steps, hn::ShiftRight<3>(bit[row])), i, &lanes.byte[row][at]);
  }
  // a brick with lists has their cells before its steps, with z = 0 and 1 in the first word; other
  // bricks read the pool's start
  const auto has_lists =
      hn::Ne(hn::And(brick.flags, hn::Set(i, FieldBrick::kHasLists)), hn::Zero(i));
  const Ints upper = hn::ShiftLeft<2>(hn::ShiftRight<1>(in_brick.z));
  const Ints cells =
      hn::Add(brick.steps, hn::Sub(upper, hn::Set(i, std::int32_t{sizeof(FieldLists)})));
  hn::StoreU(hn::IfThenElseZero(has_lists, cells), i, &lanes.byte[4][at]);
  const Ints in_layer = hn::Add(in_brick.x, hn::ShiftLeft<2>(in_brick.y));
  const Ints layer = hn::ShiftLeft<4>(hn::And(in_brick.z, hn::Set(i, 1)));
  hn::StoreU(hn::Add(in_layer, layer), i, &lanes.cell_bit[at]);
}

/// Returns which lanes' cells have a list.
HWY_INLINE hn::Mask<I> Listed(const FieldLanes& lanes, std::size_t at) {
  const I i;
  const Ints flags = hn::LoadU(i, &lanes.flags[at]);
  const auto has_lists = hn::Ne(hn::And(flags, hn::Set(i, FieldBrick::kHasLists)), hn::Zero(i));
  const hn::RebindToUnsigned<I> u;
  const auto cells = hn::BitCast(u, hn::LoadU(i, &lanes.word[4][at]));
  const Ints one =
      hn::And(hn::BitCast(i, hn::Shr(cells, hn::BitCast(u, hn::LoadU(i, &lanes.cell_bit[at])))),
              hn::Set(i, 1));
  return hn::And(has_lists, hn::Ne(one, hn::Zero(i)));
}

/// Returns the values at the eight nodes of a cell, x fastest.
HWY_INLINE std::array<Floats, 8> NodesOf(const FieldLanes& lanes, const Bricks& brick,
                                         const IntLanes3& in_brick, std::size_t at) {
  const F f;
  const I i;
  const Floats step = StepOf(brick.bits, brick.flags);
  const Floats slope = hn::Set(f, FieldBrick::kSlope);
  const Floats along_x = hn::Mul(slope, hn::ConvertTo(f, brick.slopes.x));
  const std::array<Ints, 4> bit = RowBits(brick.bits, hn::LoadU(i, &lanes.first_bit[at]));
  const Lanes3 lowest = ToFloats(in_brick);
  std::array<Floats, 8> nodes;
  for (std::size_t row = 0; row < 4; ++row) {
    const Floats one = hn::Set(f, 1.0F);
    const Lanes3 place{lowest.x, (row & 1) != 0 ? hn::Add(lowest.y, one) : lowest.y,
                       row >= 2 ? hn::Add(lowest.z, one) : lowest.z};
    const Floats plane = PlaneAt(brick, place);
    const RowSteps steps = StepsOfRow(brick.bits, bit[row], hn::LoadU(i, &lanes.word[row][at]));
    nodes[2 * row] = hn::Add(plane, hn::Mul(step, steps.low));
    nodes[2 * row + 1] = hn::Add(hn::Add(plane, along_x), hn::Mul(step, steps.high));
  }
  return nodes;
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
