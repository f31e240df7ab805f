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
  Ints bits, over_of_lists, flags, steps;
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
          hn::And(hn::ShiftRight<16>(last), hn::Set(i, 15)),
          hn::And(hn::ShiftRight<20>(last), hn::Set(i, 15)),
          hn::And(hn::ShiftRight<24>(last), hn::Set(i, 0xff)),
          at(3)};
}

/// The steps of a node and its neighbour along x, interpolated.
HWY_INLINE Floats StepBetween(const FieldView& field, Ints bits, Ints steps, Ints node,
                              Floats share) {
  const F f;
  const I i;
  const Ints bit = hn::Mul(node, bits);
  const Ints byte = hn::Add(steps, hn::ShiftRight<3>(bit));
  const Ints word = hn::GatherOffset(i, reinterpret_cast<const std::int32_t*>(field.steps), byte);
  const Ints unused = hn::Sub(hn::Set(i, 32), bits);
  const Ints skipped = hn::And(bit, hn::Set(i, 7));
  const Ints low = hn::Shr(hn::Shl(word, hn::Sub(unused, skipped)), unused);
  const Ints high = hn::Shr(hn::Shl(word, hn::Sub(hn::Sub(unused, skipped), bits)), unused);
  return Between(hn::ConvertTo(f, low), hn::ConvertTo(f, high), share);
}

/// Which lanes' cells have a list; `bit` of a cell in its brick.
HWY_INLINE hn::Mask<I> Listed(const FieldView& field, Ints flags, Ints steps, Ints bit) {
  const I i;
  const auto has_lists = hn::Ne(hn::And(flags, hn::Set(i, FieldBrick::kHasLists)), hn::Zero(i));
  if (hn::AllFalse(i, has_lists)) return has_lists;
  // a brick with lists has their cells before its steps; others read the pool's begin
  const Ints word = hn::Add(
      steps, hn::Sub(hn::ShiftLeft<2>(hn::ShiftRight<5>(bit)), hn::Set(i, sizeof(FieldLists))));
  const Ints at = hn::IfThenElseZero(has_lists, word);
  const Ints cells = hn::GatherOffset(i, reinterpret_cast<const std::int32_t*>(field.steps), at);
  const hn::RebindToUnsigned<I> u;
  const auto shifted =
      hn::Shr(hn::BitCast(u, cells), hn::And(hn::BitCast(u, bit), hn::Set(u, 31U)));
  const Ints one = hn::And(hn::BitCast(i, shifted), hn::Set(i, 1));
  return hn::And(has_lists, hn::Ne(one, hn::Zero(i)));
}

/// Vectors of places on their way. A look-up is a chain of reads, each of which needs the one
/// before, so all vectors take one step before any takes the next: they wait side by side.
struct Batch {
  static constexpr std::size_t kVectors = 16;
  static constexpr std::size_t kLanes = 16;
  template <class T>
  using Lanes = std::array<T, kVectors * kLanes>;
  // after Find()
  alignas(64) Lanes<float> x, y, z;       // from the cell's lowest node
  alignas(64) Lanes<std::int32_t> cell;   // in its brick: x + 4 y + 16 z
  alignas(64) Lanes<std::int32_t> entry;  // number of the brick; below 0: none
  alignas(64) Lanes<float> value;         // a bound, where there is none
  // after ReadBricks()
  alignas(64) Lanes<float> plane;
  alignas(64) Lanes<std::int32_t> bits, over_of_lists, flags, steps;
  // after ReadSteps()
  alignas(64) Lanes<std::int32_t> kind;
  alignas(64) Lanes<float> over;
};

/// Finds the bricks of a vector of places, which are counted from `base`.
HWY_INLINE void Find(const FieldView& field, const GridIndex& base, const Axes& place_V,
                     std::size_t v, Batch& batch) {
  const F f;
  const I i;
  const Ints below_zero = hn::Set(i, -1);
  // from V to L
  const Floats half = hn::Set(f, 0.5F);
  const Axes place{hn::Sub(place_V.x, half), hn::Sub(place_V.y, half), hn::Sub(place_V.z, half)};
  const Axes floor{hn::Floor(place.x), hn::Floor(place.y), hn::Floor(place.z)};
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
  if (!hn::AllTrue(i, inside)) {
    const Axes place_L{hn::Add(place.x, hn::Set(f, static_cast<float>(base.x))),
                       hn::Add(place.y, hn::Set(f, static_cast<float>(base.y))),
                       hn::Add(place.z, hn::Set(f, static_cast<float>(base.z)))};
    value = hn::IfThenElse(hn::RebindMask(f, inside), value, OfBox(field, place_L));
    entry = hn::IfThenElse(inside, entry, below_zero);
  }
  const std::size_t at = v * Batch::kLanes;
  hn::StoreU(hn::Sub(place.x, floor.x), f, &batch.x[at]);
  hn::StoreU(hn::Sub(place.y, floor.y), f, &batch.y[at]);
  hn::StoreU(hn::Sub(place.z, floor.z), f, &batch.z[at]);
  const Ints three = hn::Set(i, 3);
  hn::StoreU(hn::Add(hn::And(cell.x, three), hn::Add(hn::ShiftLeft<2>(hn::And(cell.y, three)),
                                                     hn::ShiftLeft<4>(hn::And(cell.z, three)))),
             i, &batch.cell[at]);
  hn::StoreU(entry, i, &batch.entry[at]);
  hn::StoreU(value, f, &batch.value[at]);
}

HWY_INLINE void ReadBricks(const FieldView& field, std::size_t v, Batch& batch) {
  const F f;
  const I i;
  const std::size_t at = v * Batch::kLanes;
  const Brick brick = BrickOf(field, hn::Max(hn::LoadU(i, &batch.entry[at]), hn::Zero(i)));
  const Ints cell = hn::LoadU(i, &batch.cell[at]);
  const Ints three = hn::Set(i, 3);
  const auto slope = [&](Ints slopes, Ints along, Floats share) {
    return hn::Mul(hn::ConvertTo(f, slopes), hn::Add(hn::ConvertTo(f, along), share));
  };
  const Floats plane =
      hn::Add(hn::Add(slope(brick.slopes.x, hn::And(cell, three), hn::LoadU(f, &batch.x[at])),
                      slope(brick.slopes.y, hn::And(hn::ShiftRight<2>(cell), three),
                            hn::LoadU(f, &batch.y[at]))),
              slope(brick.slopes.z, hn::ShiftRight<4>(cell), hn::LoadU(f, &batch.z[at])));
  hn::StoreU(hn::Add(brick.mean, hn::Mul(hn::Set(f, FieldBrick::kSlope), plane)), f,
             &batch.plane[at]);
  hn::StoreU(brick.bits, i, &batch.bits[at]);
  hn::StoreU(brick.over_of_lists, i, &batch.over_of_lists[at]);
  hn::StoreU(brick.flags, i, &batch.flags[at]);
  hn::StoreU(brick.steps, i, &batch.steps[at]);
}

HWY_INLINE void ReadSteps(const FieldView& field, std::size_t v, Batch& batch) {
  const F f;
  const I i;
  const std::size_t lane = v * Batch::kLanes;
  auto near = hn::Gt(hn::LoadU(i, &batch.entry[lane]), hn::Set(i, -1));
  const Ints bits = hn::LoadU(i, &batch.bits[lane]);
  const Ints flags = hn::LoadU(i, &batch.flags[lane]);
  const Ints steps = hn::LoadU(i, &batch.steps[lane]);
  const Ints cell = hn::LoadU(i, &batch.cell[lane]);
  const Floats from_x = hn::LoadU(f, &batch.x[lane]);
  const Floats from_y = hn::LoadU(f, &batch.y[lane]);
  const Floats from_z = hn::LoadU(f, &batch.z[lane]);
  // x + 4 y + 16 z, and y + 9 z more
  const Ints z = hn::ShiftRight<4>(cell);
  const Ints node = hn::Add(hn::Add(cell, hn::And(hn::ShiftRight<2>(cell), hn::Set(i, 3))),
                            hn::Add(z, hn::ShiftLeft<3>(z)));
  const auto step_at = [&](int beyond) {
    return StepBetween(field, bits, steps, hn::Add(node, hn::Set(i, beyond)), from_x);
  };
  const Floats low = Between(step_at(0), step_at(5), from_y);
  const Floats high = Between(step_at(25), step_at(30), from_y);
  const auto large = hn::Ne(hn::And(flags, hn::Set(i, FieldBrick::kLargeSteps)), hn::Zero(i));
  const Floats step = hn::IfThenElse(hn::RebindMask(f, large), hn::Set(f, 2 * FieldBrick::kStep),
                                     hn::Set(f, FieldBrick::kStep));
  // the steps of a flat brick are none
  const auto flat = hn::RebindMask(f, hn::Eq(bits, hn::Zero(i)));
  const Floats told = hn::Add(hn::LoadU(f, &batch.plane[lane]),
                              hn::IfThenZeroElse(flat, hn::Mul(step, Between(low, high, from_z))));
  const auto listed = hn::And(near, Listed(field, flags, steps, cell));
  const Floats of_brick = hn::Mul(hn::Set(f, FieldBrick::kOverStep),
                                  hn::ConvertTo(f, hn::ShiftRight<FieldBrick::kOverShift>(flags)));
  const auto outside = hn::Or(hn::Gt(told, hn::Set(f, field.most_near)),
                              hn::Lt(told, hn::Set(f, -field.most_near_inside)));
  const auto beyond = hn::AndNot(listed, hn::RebindMask(i, outside));
  const Floats bound =
      hn::IfThenElse(hn::Gt(told, hn::Zero(f)), hn::Sub(hn::Set(f, field.most_near), of_brick),
                     hn::Set(f, -field.beyond_near));
  hn::StoreU(hn::IfThenElse(hn::RebindMask(f, near),
                            hn::IfThenElse(hn::RebindMask(f, beyond), bound, told),
                            hn::LoadU(f, &batch.value[lane])),
             f, &batch.value[lane]);
  near = hn::AndNot(beyond, near);
  const Floats of_lists = hn::Mul(hn::Set(f, FieldBrick::kListsOverStep),
                                  hn::ConvertTo(f, hn::LoadU(i, &batch.over_of_lists[lane])));
  hn::StoreU(hn::IfThenElse(hn::RebindMask(f, listed), of_lists,
                            hn::IfThenElseZero(hn::RebindMask(f, near), of_brick)),
             f, &batch.over[lane]);
  hn::StoreU(hn::IfThenElse(listed, hn::Set(i, FieldView::kListed),
                            hn::IfThenElseZero(near, hn::Set(i, FieldView::kNear))),
             i, &batch.kind[lane]);
}

/// What `count` vectors read whose places have been found.
HWY_INLINE void ReadAll(const FieldView& field, std::size_t count, Batch& batch) {
  const F f;
  const I i;
  std::array<std::uint8_t, Batch::kVectors> near;
  for (std::size_t v = 0; v < count; ++v) {
    const Ints entry = hn::LoadU(i, &batch.entry[v * Batch::kLanes]);
    near[v] = hn::AllTrue(i, hn::Lt(entry, hn::Zero(i))) ? 0 : 1;
    hn::StoreU(hn::Zero(f), f, &batch.over[v * Batch::kLanes]);
    hn::StoreU(hn::Zero(i), i, &batch.kind[v * Batch::kLanes]);
    if (near[v] != 0) ReadBricks(field, v, batch);
  }
  for (std::size_t v = 0; v < count; ++v) {
    if (near[v] != 0) ReadSteps(field, v, batch);
  }
}

void LookUp(const FieldView& field, const GridIndex& base, const PlaceSpans& places,
            std::size_t count, float* values, std::int32_t* kinds, float* over) {
  const F f;
  const I i;
  constexpr std::size_t kLanes = hn::MaxLanes(F());
  Batch batch;
  for (std::size_t begin = 0; begin < count; begin += Batch::kVectors * kLanes) {
    const std::size_t vectors = std::min(Batch::kVectors, (count - begin) / kLanes);
    for (std::size_t v = 0; v < vectors; ++v) {
      const std::size_t k = begin + v * kLanes;
      Find(field, base,
           {hn::LoadU(f, places.x + k), hn::LoadU(f, places.y + k), hn::LoadU(f, places.z + k)}, v,
           batch);
    }
    ReadAll(field, vectors, batch);
    for (std::size_t v = 0; v < vectors; ++v) {
      const std::size_t k = begin + v * kLanes;
      const std::size_t at = v * Batch::kLanes;
      hn::StoreU(hn::LoadU(f, &batch.value[at]), f, values + k);
      hn::StoreU(hn::LoadU(i, &batch.kind[at]), i, kinds + k);
      if (over != nullptr) hn::StoreU(hn::LoadU(f, &batch.over[at]), f, over + k);
    }
  }
}

/// What DistanceField::AtLeast() is nowhere below.
HWY_INLINE Floats AtLeast(const FieldView& field, Floats value) {
  const F f;
  const Floats fine = hn::Set(f, field.fine_band);
  const Floats least = hn::Max(fine, hn::Sub(value, hn::Set(f, field.most_over)));
  return hn::IfThenElse(hn::Le(value, fine), value, least);
}

/// What a block's vectors, from `v` on, come to.
HWY_INLINE FieldReadings Sum(const FieldView& field, float reach, std::size_t v, const Batch& batch,
                             float* bounds) {
  const F f;
  const I i;
  constexpr std::size_t kLanes = hn::MaxLanes(F());
  Floats least = hn::Set(f, std::numeric_limits<float>::max());
  std::uint64_t within = 0;
  std::uint64_t open = 0;
  for (std::size_t k = 0; k < kBlockPlaces; k += kLanes, ++v) {
    const std::size_t at = v * Batch::kLanes;
    const Floats value = hn::LoadU(f, &batch.value[at]);
    const Ints kind = hn::LoadU(i, &batch.kind[at]);
    const auto near = hn::RebindMask(f, hn::Eq(kind, hn::Set(i, FieldView::kNear)));
    const auto listed = hn::RebindMask(f, hn::Eq(kind, hn::Set(i, FieldView::kListed)));
    const Floats at_least = AtLeast(field, value);
    // where no list tells: exact within the band, and beyond it not nearer than its border
    const Floats over = hn::Sub(value, hn::LoadU(f, &batch.over[at]));
    const Floats least_here =
        hn::Sub(hn::Min(value, hn::Set(f, field.band)), hn::Set(f, field.error));
    const Floats bound = hn::IfThenElse(near, hn::Max(over, least_here), over);
    // what a list tells is decided only where that is far
    const auto is_open = hn::And(listed, hn::Lt(hn::Min(bound, at_least), hn::Set(f, reach)));
    // every place that DistanceField::Pushes() pushes is found
    const Floats told = hn::IfThenElse(near, at_least, bound);
    const auto is_within = hn::AndNot(is_open, hn::Lt(told, hn::Set(f, reach)));
    least = hn::Min(least, hn::IfThenElse(is_open, least, bound));
    hn::StoreU(hn::IfThenElse(is_open, value, bound), f, bounds + k);
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(f, is_open, bits.data());
    open |= (bits[0] | std::uint64_t{bits[1]} << 8U) << k;
    bits = {};
    hn::StoreMaskBits(f, is_within, bits.data());
    within |= (bits[0] | std::uint64_t{bits[1]} << 8U) << k;
  }
  return {hn::GetLane(hn::MinOfLanes(f, least)), static_cast<std::uint16_t>(within),
          static_cast<std::uint16_t>(open)};
}

void LookUpBlocks(const FieldView& field, const std::array<float, 9>& R_VF, float reach,
                  const PlacedBlock* blocks, std::size_t count, float* bounds,
                  FieldReadings* readings) {
  const F f;
  constexpr std::size_t kLanes = hn::MaxLanes(F());
  constexpr std::size_t kVectors = kBlockPlaces / kLanes;  // of a block
  constexpr std::size_t kTogether = std::max<std::size_t>(1, Batch::kVectors / kVectors);
  Batch batch;
  for (std::size_t begin = 0; begin < count; begin += kTogether) {
    const std::size_t together = std::min(kTogether, count - begin);
    for (std::size_t b = 0; b < together; ++b) {
      const PlacedBlock& block = blocks[begin + b];
      for (std::size_t part = 0; part < kVectors; ++part) {
        const Floats x = hn::LoadU(f, block.places_F.x + part * kLanes);
        const Floats y = hn::LoadU(f, block.places_F.y + part * kLanes);
        const Floats z = hn::LoadU(f, block.places_F.z + part * kLanes);
        const auto along = [&](std::size_t axis) {
          const auto turned = [&](Floats value, std::size_t column) {
            return hn::Mul(hn::Set(f, R_VF[3 * axis + column]), value);
          };
          return hn::Add(hn::Set(f, block.from_base[axis]),
                         hn::Add(hn::Add(turned(x, 0), turned(y, 1)), turned(z, 2)));
        };
        Find(field, block.base, {along(0), along(1), along(2)}, b * kVectors + part, batch);
      }
    }
    ReadAll(field, together * kVectors, batch);
    for (std::size_t b = 0; b < together; ++b) {
      readings[begin + b] =
          Sum(field, reach, b * kVectors, batch, bounds + kBlockPlaces * (begin + b));
    }
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
  view.most_near = static_cast<float>(most_near_);
  view.most_near_inside = static_cast<float>(kMostNear);
  view.beyond_near = static_cast<float>(kMostNear - outer_error_bound_);
  view.band = static_cast<float>(band_);
  view.error = static_cast<float>(error_bound_);
  view.fine_band = static_cast<float>(fine_band());
  view.most_over = static_cast<float>(most_over_);
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
