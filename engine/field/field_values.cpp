#include <limits>

#include "engine/field/distance_field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/field/field_values.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using Floats = hn::Vec<F>;
using Ints = hn::Vec<I>;

struct Axes {
  Floats x, y, z;
};
struct IntAxes {
  Ints x, y, z;
};

HWY_INLINE Floats Between(Floats low, Floats high, Floats share) {
  return hn::Add(low, hn::Mul(share, hn::Sub(high, low)));
}

/// The low `bits` of each lane as a signed number.
template <int kBits>
HWY_INLINE Ints SignedLow(Ints lanes) {
  return hn::ShiftRight<32 - kBits>(hn::ShiftLeft<32 - kBits>(lanes));
}

/// What a table's bound says: DistanceField::BoundEntry().
HWY_INLINE Floats OfBounds(Ints entries) {
  const F f;
  const I i;
  const Ints code = hn::Not(entries);
  const Floats least =
      hn::Mul(hn::Set(f, FieldView::kBoundStep), hn::ConvertTo(f, hn::ShiftRight<1>(code)));
  const auto inside = hn::Ne(hn::And(code, hn::Set(i, 1)), hn::Zero(i));
  return hn::IfThenElse(hn::RebindMask(f, inside), hn::Neg(least), least);
}

/// Outside all tables: the distance from the box of all faces, less what single precision may add.
HWY_INLINE Floats OfBox(const FieldView& field, const Axes& place_L) {
  const F f;
  const auto beyond = [&](Floats place, float least, float most) {
    return hn::Max(hn::Zero(f),
                   hn::Max(hn::Sub(hn::Set(f, least), place), hn::Sub(place, hn::Set(f, most))));
  };
  const Floats x = beyond(place_L.x, field.box_min[0], field.box_max[0]);
  const Floats y = beyond(place_L.y, field.box_min[1], field.box_max[1]);
  const Floats z = beyond(place_L.z, field.box_min[2], field.box_max[2]);
  const Floats squared = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
  const Floats distance = hn::Mul(hn::Set(f, 0.999F), hn::Sqrt(squared));
  return hn::Max(hn::Zero(f), hn::Sub(distance, hn::Set(f, 0.01F)));
}

struct Brick {
  Floats mean;
  IntAxes slopes;
  Ints bits, flags, steps;
};

HWY_INLINE Brick BrickOf(const FieldView& field, Ints number) {
  const F f;
  const I i;
  const Ints word = hn::ShiftLeft<2>(number);
  const auto at = [&](int k) {
    return hn::GatherIndex(i, field.bricks, hn::Add(word, hn::Set(i, k)));
  };
  const Ints slopes = at(1);
  const Ints last = at(2);
  return {hn::BitCast(f, at(0)),
          {SignedLow<16>(slopes), hn::ShiftRight<16>(slopes), SignedLow<16>(last)},
          hn::And(hn::ShiftRight<16>(last), hn::Set(i, 0xff)),
          hn::And(hn::ShiftRight<24>(last), hn::Set(i, 0xff)),
          at(3)};
}

/// The steps of a node and its neighbour along x, interpolated.
HWY_INLINE Floats StepBetween(const FieldView& field, const Brick& brick, Ints node, Floats share) {
  const F f;
  const I i;
  const Ints bit = hn::Mul(node, brick.bits);
  const Ints byte = hn::Add(brick.steps, hn::ShiftRight<3>(bit));
  const Ints word = hn::GatherOffset(i, reinterpret_cast<const std::int32_t*>(field.steps), byte);
  const Ints unused = hn::Sub(hn::Set(i, 32), brick.bits);
  const Ints skipped = hn::And(bit, hn::Set(i, 7));
  const Ints low = hn::Shr(hn::Shl(word, hn::Sub(unused, skipped)), unused);
  const Ints high = hn::Shr(hn::Shl(word, hn::Sub(hn::Sub(unused, skipped), brick.bits)), unused);
  return Between(hn::ConvertTo(f, low), hn::ConvertTo(f, high), share);
}

/// Which lanes' cells have a list.
HWY_INLINE hn::Mask<I> Listed(const FieldView& field, const Brick& brick, const IntAxes& in_brick) {
  const I i;
  const Ints bit =
      hn::Add(in_brick.x, hn::Add(hn::ShiftLeft<2>(in_brick.y), hn::ShiftLeft<4>(in_brick.z)));
  const auto has_lists =
      hn::Ne(hn::And(brick.flags, hn::Set(i, FieldBrick::kHasLists)), hn::Zero(i));
  if (hn::AllFalse(i, has_lists)) return has_lists;
  // a brick with lists has their cells before its steps; others read the pool's begin
  const Ints word = hn::Add(brick.steps, hn::Sub(hn::ShiftLeft<2>(hn::ShiftRight<5>(bit)),
                                                 hn::Set(i, sizeof(FieldLists))));
  const Ints at = hn::IfThenElseZero(has_lists, word);
  const Ints cells = hn::GatherOffset(i, reinterpret_cast<const std::int32_t*>(field.steps), at);
  const hn::RebindToUnsigned<I> u;
  const auto shifted =
      hn::Shr(hn::BitCast(u, cells), hn::And(hn::BitCast(u, bit), hn::Set(u, 31U)));
  const Ints one = hn::And(hn::BitCast(i, shifted), hn::Set(i, 1));
  return hn::And(has_lists, hn::Ne(one, hn::Zero(i)));
}

struct Reading {
  Floats value;
  Ints kind;
  Floats over;
};

/// `place_V` from `base`.
HWY_INLINE Reading Read(const FieldView& field, const GridIndex& base, const Axes& place_V) {
  const F f;
  const I i;
  const Ints below_zero = hn::Set(i, -1);
  // from V to L
  const Floats half = hn::Set(f, 0.5F);
  const Axes place{hn::Sub(place_V.x, half), hn::Sub(place_V.y, half), hn::Sub(place_V.z, half)};
  const Axes floor{hn::Floor(place.x), hn::Floor(place.y), hn::Floor(place.z)};
  const Axes from{hn::Sub(place.x, floor.x), hn::Sub(place.y, floor.y), hn::Sub(place.z, floor.z)};
  IntAxes cell{hn::Add(hn::ConvertTo(i, floor.x), hn::Set(i, base.x)),
               hn::Add(hn::ConvertTo(i, floor.y), hn::Set(i, base.y)),
               hn::Add(hn::ConvertTo(i, floor.z), hn::Set(i, base.z))};
  const auto holds = [&](Ints at, std::int32_t size) {
    return hn::And(hn::Gt(at, below_zero), hn::Lt(at, hn::Set(i, size)));
  };
  const auto inside = hn::And(holds(cell.x, field.cells.x),
                              hn::And(holds(cell.y, field.cells.y), holds(cell.z, field.cells.z)));
  cell = {hn::IfThenElseZero(inside, cell.x), hn::IfThenElseZero(inside, cell.y),
          hn::IfThenElseZero(inside, cell.z)};
  const Ints hyperbrick = hn::Add(
      hn::ShiftRight<5>(cell.x),
      hn::Mul(hn::Set(i, field.hyperbricks_x),
              hn::Add(hn::ShiftRight<5>(cell.y),
                      hn::Mul(hn::Set(i, field.hyperbricks_y), hn::ShiftRight<5>(cell.z)))));
  Ints entry = hn::GatherIndex(i, field.hyperbricks, hyperbrick);
  const auto has_table = hn::Gt(entry, below_zero);
  const Ints seven = hn::Set(i, 7);
  const Ints in_table =
      hn::Add(hn::And(hn::ShiftRight<2>(cell.x), seven),
              hn::Add(hn::ShiftLeft<3>(hn::And(hn::ShiftRight<2>(cell.y), seven)),
                      hn::ShiftLeft<6>(hn::And(hn::ShiftRight<2>(cell.z), seven))));
  if (!hn::AllFalse(i, has_table)) {
    const Ints table = hn::IfThenElseZero(has_table, entry);
    const Ints at = hn::ShiftLeft<1>(hn::Add(hn::ShiftLeft<9>(table), in_table));
    // four bytes, of which two are the entry
    const Ints told =
        SignedLow<16>(hn::GatherOffset(i, reinterpret_cast<const std::int32_t*>(field.tables), at));
    const Ints number = hn::Add(told, hn::GatherIndex(i, field.first_bricks, table));
    entry =
        hn::IfThenElse(has_table, hn::IfThenElse(hn::Gt(told, below_zero), number, told), entry);
  }
  Floats value = OfBounds(entry);
  Floats over = hn::Zero(f);
  auto near = hn::And(inside, hn::Gt(entry, below_zero));
  auto listed = hn::And(near, hn::Not(near));
  if (!hn::AllFalse(i, near)) {
    const Brick brick = BrickOf(field, hn::IfThenElseZero(near, entry));
    const Ints three = hn::Set(i, 3);
    const IntAxes in_brick{hn::And(cell.x, three), hn::And(cell.y, three), hn::And(cell.z, three)};
    const Ints node = hn::Add(in_brick.x, hn::Add(hn::Mul(in_brick.y, hn::Set(i, 5)),
                                                  hn::Mul(in_brick.z, hn::Set(i, 25))));
    const auto step_at = [&](int beyond) {
      return StepBetween(field, brick, hn::Add(node, hn::Set(i, beyond)), from.x);
    };
    const Floats low = Between(step_at(0), step_at(5), from.y);
    const Floats high = Between(step_at(25), step_at(30), from.y);
    const auto large =
        hn::Ne(hn::And(brick.flags, hn::Set(i, FieldBrick::kLargeSteps)), hn::Zero(i));
    const Floats step = hn::IfThenElse(hn::RebindMask(f, large), hn::Set(f, 2 * FieldBrick::kStep),
                                       hn::Set(f, FieldBrick::kStep));
    // the steps of a flat brick are none
    const auto flat = hn::RebindMask(f, hn::Eq(brick.bits, hn::Zero(i)));
    const auto slope = [&](Ints slopes, Ints at, Floats share) {
      return hn::Mul(hn::ConvertTo(f, slopes), hn::Add(hn::ConvertTo(f, at), share));
    };
    const Floats plane = hn::Add(hn::Add(slope(brick.slopes.x, in_brick.x, from.x),
                                         slope(brick.slopes.y, in_brick.y, from.y)),
                                 slope(brick.slopes.z, in_brick.z, from.z));
    const Floats told =
        hn::Add(hn::Add(brick.mean, hn::Mul(hn::Set(f, FieldBrick::kSlope), plane)),
                hn::IfThenZeroElse(flat, hn::Mul(step, Between(low, high, from.z))));
    listed = hn::And(near, Listed(field, brick, in_brick));
    const Floats of_brick =
        hn::Mul(hn::Set(f, FieldBrick::kOverStep),
                hn::ConvertTo(f, hn::ShiftRight<FieldBrick::kOverShift>(brick.flags)));
    const auto beyond =
        hn::AndNot(listed, hn::RebindMask(i, hn::Gt(hn::Abs(told), hn::Set(f, field.most_near))));
    const Floats bound =
        hn::IfThenElse(hn::Gt(told, hn::Zero(f)), hn::Sub(hn::Set(f, field.most_near), of_brick),
                       hn::Set(f, -field.beyond_near));
    value = hn::IfThenElse(hn::RebindMask(f, near),
                           hn::IfThenElse(hn::RebindMask(f, beyond), bound, told), value);
    near = hn::AndNot(beyond, near);
    over = hn::IfThenElse(hn::RebindMask(f, listed), hn::Set(f, field.over_of_lists),
                          hn::IfThenElseZero(hn::RebindMask(f, near), of_brick));
  }
  if (!hn::AllTrue(i, inside)) {
    const Axes place_L{hn::Add(place.x, hn::Set(f, static_cast<float>(base.x))),
                       hn::Add(place.y, hn::Set(f, static_cast<float>(base.y))),
                       hn::Add(place.z, hn::Set(f, static_cast<float>(base.z)))};
    value = hn::IfThenElse(hn::RebindMask(f, inside), value, OfBox(field, place_L));
  }
  const Ints kind = hn::IfThenElse(listed, hn::Set(i, FieldView::kListed),
                                   hn::IfThenElseZero(near, hn::Set(i, FieldView::kNear)));
  return {value, kind, over};
}

void LookUp(const FieldView& field, const GridIndex& base, const PlaceSpans& places,
            std::size_t count, float* values, std::int32_t* kinds, float* over) {
  const F f;
  const I i;
  for (std::size_t k = 0; k < count; k += hn::Lanes(f)) {
    const Axes place{hn::LoadU(f, places.x + k), hn::LoadU(f, places.y + k),
                     hn::LoadU(f, places.z + k)};
    const Reading reading = Read(field, base, place);
    hn::StoreU(reading.value, f, values + k);
    hn::StoreU(reading.kind, i, kinds + k);
    if (over != nullptr) hn::StoreU(reading.over, f, over + k);
  }
}

void LookUpBlocks(const FieldView& field, const std::array<float, 9>& R_VF, float reach,
                  const PlacedBlock* blocks, std::size_t count, float* values,
                  FieldReadings* readings) {
  const F f;
  const I i;
  for (std::size_t b = 0; b < count; ++b) {
    const PlacedBlock& block = blocks[b];
    Floats least = hn::Set(f, std::numeric_limits<float>::max());
    std::uint64_t within = 0;
    std::uint64_t open = 0;
    for (std::size_t k = 0; k < kBlockPlaces; k += hn::Lanes(f)) {
      const Floats x = hn::LoadU(f, block.places_F.x + k);
      const Floats y = hn::LoadU(f, block.places_F.y + k);
      const Floats z = hn::LoadU(f, block.places_F.z + k);
      const auto along = [&](std::size_t axis) {
        const auto turned = [&](Floats value, std::size_t column) {
          return hn::Mul(hn::Set(f, R_VF[3 * axis + column]), value);
        };
        return hn::Add(hn::Set(f, block.from_base[axis]),
                       hn::Add(hn::Add(turned(x, 0), turned(y, 1)), turned(z, 2)));
      };
      const Reading reading = Read(field, block.base, {along(0), along(1), along(2)});
      const auto near = hn::RebindMask(f, hn::Eq(reading.kind, hn::Set(i, FieldView::kNear)));
      const auto listed = hn::RebindMask(f, hn::Eq(reading.kind, hn::Set(i, FieldView::kListed)));
      const auto in_band = hn::Le(hn::Abs(reading.value), hn::Set(f, field.band));
      // where no list tells: exact within the band, and beyond it not nearer than its border
      const Floats over = hn::Sub(reading.value, reading.over);
      const Floats least_here =
          hn::Sub(hn::Min(reading.value, hn::Set(f, field.band)), hn::Set(f, field.error));
      const Floats bound = hn::IfThenElse(near, hn::Max(over, least_here), over);
      // what a list tells is decided only where that is far
      const auto is_open = hn::And(listed, hn::Lt(bound, hn::Set(f, reach)));
      const Floats told = hn::IfThenElse(hn::And(near, in_band), reading.value, bound);
      const auto is_within = hn::AndNot(is_open, hn::Lt(told, hn::Set(f, reach)));
      least = hn::Min(least, hn::IfThenElse(is_open, least, bound));
      hn::StoreU(hn::IfThenElse(is_open, reading.value, bound), f, values + kBlockPlaces * b + k);
      std::array<std::uint8_t, 8> bits{};
      hn::StoreMaskBits(f, is_open, bits.data());
      open |= (bits[0] | std::uint64_t{bits[1]} << 8U) << k;
      bits = {};
      hn::StoreMaskBits(f, is_within, bits.data());
      within |= (bits[0] | std::uint64_t{bits[1]} << 8U) << k;
    }
    readings[b] = {hn::GetLane(hn::MinOfLanes(f, least)), static_cast<std::uint16_t>(within),
                   static_cast<std::uint16_t>(open)};
  }
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

namespace {
HWY_EXPORT(LookUp);
HWY_EXPORT(LookUpBlocks);
}  // namespace

FieldView DistanceField::View() const noexcept {
  FieldView view;
  view.hyperbricks = hyperbricks_.data();
  view.first_bricks = reinterpret_cast<const std::int32_t*>(first_bricks_.data());
  view.tables = tables_.data();
  view.bricks = reinterpret_cast<const std::int32_t*>(bricks_.data());
  view.steps = steps_.data();
  view.cells = size_ * kHyperbrickCells;
  view.hyperbricks_x = size_.x;
  view.hyperbricks_y = size_.y;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    view.box_min[axis] = static_cast<float>(faces_L_.min[static_cast<Eigen::Index>(axis)]);
    view.box_max[axis] = static_cast<float>(faces_L_.max[static_cast<Eigen::Index>(axis)]);
  }
  view.most_near = static_cast<float>(kMostNear);
  view.beyond_near = static_cast<float>(kMostNear - outer_error_bound_);
  view.band = static_cast<float>(band_);
  view.error = static_cast<float>(error_bound_);
  view.over_of_lists = static_cast<float>(over_of_lists_);
  return view;
}

void DistanceField::Values(const GridIndex& base, const PlaceSpans& places, std::size_t count,
                           float* values, std::int32_t* kinds, float* over) const noexcept {
  HWY_DYNAMIC_DISPATCH(LookUp)(View(), base, places, count, values, kinds, over);
}

void DistanceField::ReadBlocks(const std::array<float, 9>& R_VF, float reach,
                               std::span<const PlacedBlock> blocks, float* values,
                               FieldReadings* readings) const noexcept {
  HWY_DYNAMIC_DISPATCH(LookUpBlocks)
  (View(), R_VF, reach, blocks.data(), blocks.size(), values, readings);
}

}  // namespace tandem
#endif
