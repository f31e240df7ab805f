// The values of many places: interpolated, or bounds.
#include <algorithm>
#include <limits>

#include "engine/field/query/distance_field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/field/query/field_values.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/field/query/field_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

/// Returns the bounds of a table's entries: DistanceField::BoundEntry().
HWY_INLINE Floats ReadBounds(Ints entries) {
  const F f;
  const I i;
  const Ints code = hn::Not(entries);
  const Floats least =
      hn::Mul(hn::Set(f, FieldView::kBoundStep), hn::ConvertTo(f, hn::ShiftRight<1>(code)));
  const auto inside = hn::Ne(hn::And(code, hn::Set(i, 1)), hn::Zero(i));
  return hn::IfThenElse(hn::RebindMask(f, inside), hn::Neg(least), least);
}

/// Returns the distance from the box of all faces, for places outside all tables, less what single
/// precision may add.
HWY_INLINE Floats OfBox(const FieldView& field, const Lanes3& place_L) {
  const F f;
  const auto beyond = [&](Floats place, float least, float most) HWY_ATTR {
    return hn::Max(hn::Zero(f),
                   hn::Max(hn::Sub(hn::Set(f, least), place), hn::Sub(place, hn::Set(f, most))));
  };
  const Lanes3 offset{beyond(place_L.x, field.box_min[0], field.box_max[0]),
                      beyond(place_L.y, field.box_min[1], field.box_max[1]),
                      beyond(place_L.z, field.box_min[2], field.box_max[2])};
  const Floats distance = hn::Mul(hn::Set(f, 0.999F), hn::Sqrt(Dot(offset, offset)));
  return hn::Max(hn::Zero(f), hn::Sub(distance, hn::Set(f, 0.01F)));
}

/// Finds the cells of a vector of places relative to `base`.
HWY_INLINE void Find(const FieldView& field, const GridIndex& base, const Lanes3& place_V,
                     std::size_t at, FieldLanes& lanes) {
  const F f;
  const I i;
  // from V to L
  const Floats half = hn::Set(f, 0.5F);
  const Lanes3 place{hn::Sub(place_V.x, half), hn::Sub(place_V.y, half), hn::Sub(place_V.z, half)};
  const Lanes3 floor{hn::Floor(place.x), hn::Floor(place.y), hn::Floor(place.z)};
  const IntLanes3 cell{hn::Add(hn::ConvertTo(i, floor.x), hn::Set(i, base.x)),
                       hn::Add(hn::ConvertTo(i, floor.y), hn::Set(i, base.y)),
                       hn::Add(hn::ConvertTo(i, floor.z), hn::Set(i, base.z))};
  hn::StoreU(hn::Sub(place.x, floor.x), f, &lanes.x[at]);
  hn::StoreU(hn::Sub(place.y, floor.y), f, &lanes.y[at]);
  hn::StoreU(hn::Sub(place.z, floor.z), f, &lanes.z[at]);
  hn::StoreU(cell.x, i, &lanes.cell_x[at]);
  hn::StoreU(cell.y, i, &lanes.cell_y[at]);
  hn::StoreU(cell.z, i, &lanes.cell_z[at]);
  StoreTablePlaces(field, cell, at, lanes);
  const Ints hyperbrick = hn::LoadU(i, &lanes.hyperbrick[at]);
  if (hn::AllTrue(i, hn::Gt(hyperbrick, hn::Set(i, -1)))) return;
  const Lanes3 place_L{hn::Add(place.x, hn::Set(f, static_cast<float>(base.x))),
                       hn::Add(place.y, hn::Set(f, static_cast<float>(base.y))),
                       hn::Add(place.z, hn::Set(f, static_cast<float>(base.z)))};
  hn::StoreU(OfBox(field, place_L), f, &lanes.value[at]);
}

HWY_INLINE void Interpolate(const FieldView& field, std::size_t at, FieldLanes& lanes) {
  const F f;
  const I i;
  const Ints bits = hn::LoadU(i, &lanes.bits[at]);
  const Ints flags = hn::LoadU(i, &lanes.flags[at]);
  const Ints entry = hn::LoadU(i, &lanes.entry[at]);
  auto near = hn::Gt(entry, hn::Set(i, -1));
  const std::array<Ints, 4> bit = RowBits(bits, hn::LoadU(i, &lanes.first_bit[at]));
  const Floats from_x = hn::LoadU(f, &lanes.x[at]);
  const auto row = [&](std::size_t number) HWY_ATTR {
    const RowSteps steps = StepsOfRow(bits, bit[number], hn::LoadU(i, &lanes.word[number][at]));
    return Lerp(steps.low, steps.high, from_x);
  };
  const Floats from_y = hn::LoadU(f, &lanes.y[at]);
  const Floats low = Lerp(row(0), row(1), from_y);
  const Floats high = Lerp(row(2), row(3), from_y);
  const Floats steps = Lerp(low, high, hn::LoadU(f, &lanes.z[at]));
  const Floats value = hn::Add(hn::LoadU(f, &lanes.plane[at]), hn::Mul(StepOf(bits, flags), steps));
  const auto listed = hn::And(near, Listed(lanes, at));
  const Floats of_brick = hn::Mul(hn::Set(f, FieldBrick::kOverStep),
                                  hn::ConvertTo(f, hn::ShiftRight<FieldBrick::kOverShift>(flags)));
  const auto far_off = hn::Or(hn::Gt(value, hn::Set(f, field.most_near)),
                              hn::Lt(value, hn::Set(f, -field.most_near_inside)));
  const auto beyond = hn::AndNot(listed, hn::RebindMask(i, far_off));
  const Floats bound =
      hn::IfThenElse(hn::Gt(value, hn::Zero(f)), hn::Sub(hn::Set(f, field.most_near), of_brick),
                     hn::Set(f, -field.beyond_near));
  const auto outside = hn::Lt(hn::LoadU(i, &lanes.hyperbrick[at]), hn::Zero(i));
  const Floats far =
      hn::IfThenElse(hn::RebindMask(f, outside), hn::LoadU(f, &lanes.value[at]), ReadBounds(entry));
  hn::StoreU(hn::IfThenElse(hn::RebindMask(f, near),
                            hn::IfThenElse(hn::RebindMask(f, beyond), bound, value), far),
             f, &lanes.value[at]);
  near = hn::AndNot(beyond, near);
  const Floats root = hn::ConvertTo(f, hn::LoadU(i, &lanes.over_of_lists[at]));
  const Floats of_lists = hn::Mul(hn::Set(f, FieldBrick::kListsOverUnit), hn::Mul(root, root));
  hn::StoreU(hn::IfThenElse(hn::RebindMask(f, listed), of_lists,
                            hn::IfThenElseZero(hn::RebindMask(f, near), of_brick)),
             f, &lanes.over[at]);
  hn::StoreU(hn::IfThenElse(listed, hn::Set(i, DistanceField::kListed),
                            hn::IfThenElseZero(near, hn::Set(i, DistanceField::kNear))),
             i, &lanes.kind[at]);
}

/// Sets the values of a vector without a brick.
HWY_INLINE void TellBounds(std::size_t at, FieldLanes& lanes) {
  const F f;
  const I i;
  const auto outside = hn::Lt(hn::LoadU(i, &lanes.hyperbrick[at]), hn::Zero(i));
  hn::StoreU(hn::IfThenElse(hn::RebindMask(f, outside), hn::LoadU(f, &lanes.value[at]),
                            ReadBounds(hn::LoadU(i, &lanes.entry[at]))),
             f, &lanes.value[at]);
  hn::StoreU(hn::Zero(f), f, &lanes.over[at]);
  hn::StoreU(hn::Zero(i), i, &lanes.kind[at]);
}

/// Reads the lanes whose cells have been found.
HWY_INLINE void ReadAll(const FieldView& field, std::size_t count, FieldLanes& lanes) {
  const auto near = [&](std::size_t at) HWY_ATTR {
    return lanes.near[at / FieldLanes::kVector];
  };
  ReadBricks(field, count, lanes);
  for (std::size_t at = 0; at < count; at += kWidth) {
    if (near(at)) Unpack(at, lanes);
  }
  ReadWords(field, count, FieldLanes::kWords, lanes);
  for (std::size_t at = 0; at < count; at += kWidth) {
    if (near(at)) {
      Interpolate(field, at, lanes);
    } else {
      TellBounds(at, lanes);
    }
  }
}

void LookUpAll(const FieldView& field, const GridIndex& base, const PlaceSpans& places,
               std::size_t count, FieldLanes& lanes) {
  const F f;
  for (std::size_t at = 0; at < count; at += kWidth) {
    Find(field, base,
         {hn::LoadU(f, places.x + at), hn::LoadU(f, places.y + at), hn::LoadU(f, places.z + at)},
         at, lanes);
  }
  ReadAll(field, count, lanes);
}

/// Returns a value that DistanceField::AtLeast() is nowhere below.
HWY_INLINE Floats AtLeast(const FieldView& field, Floats value) {
  const F f;
  const Floats fine = hn::Set(f, field.fine_band);
  const Floats least = hn::Max(fine, hn::Sub(value, hn::Set(f, field.most_over)));
  return hn::IfThenElse(hn::Le(value, fine), value, least);
}

/// Returns the readings of a block's lanes, from `at` on.
HWY_INLINE FieldReadings Sum(const FieldView& field, float reach, std::size_t at,
                             const FieldLanes& lanes, float* bounds) {
  const F f;
  const I i;
  Floats least = hn::Set(f, std::numeric_limits<float>::max());
  // beyond the fine band force may begin before the bound allows it
  const bool pushes_early = reach > field.fine_band;
  std::uint64_t within = 0;
  std::uint64_t listed = 0;
  for (std::size_t k = 0; k < kBlockPlaces; k += kWidth) {
    const Floats value = hn::LoadU(f, &lanes.value[at + k]);
    const Ints kind = hn::LoadU(i, &lanes.kind[at + k]);
    const auto near = hn::RebindMask(f, hn::Eq(kind, hn::Set(i, DistanceField::kNear)));
    const auto has_list = hn::RebindMask(f, hn::Eq(kind, hn::Set(i, DistanceField::kListed)));
    const Floats at_least = AtLeast(field, value);
    // without a list: exact within the band, and beyond it not nearer than its border
    const Floats over = hn::Sub(value, hn::LoadU(f, &lanes.over[at + k]));
    const Floats least_here =
        hn::Sub(hn::Min(value, hn::Set(f, field.band)), hn::Set(f, field.error));
    const Floats bound = hn::IfThenElse(near, hn::Max(over, least_here), over);
    // a list decides only where the bound does not
    const auto open = hn::And(has_list, hn::Lt(hn::Min(bound, at_least), hn::Set(f, reach)));
    // finds every place that DistanceField::Pushes() pushes
    const Floats certain = hn::IfThenElse(near, at_least, bound);
    const auto is_within = hn::AndNot(open, hn::Lt(certain, hn::Set(f, reach)));
    least =
        hn::Min(least, hn::IfThenElse(open, least, pushes_early ? hn::Min(bound, certain) : bound));
    hn::StoreU(bound, f, bounds + k);
    listed |= std::uint64_t{MaskBits(f, open)} << k;
    within |= std::uint64_t{MaskBits(f, is_within)} << k;
  }
  return {hn::GetLane(hn::MinOfLanes(f, least)), static_cast<std::uint16_t>(within),
          static_cast<std::uint16_t>(listed)};
}

void LookUpBlocks(const FieldView& field, const std::array<float, 9>& R_VF, float reach,
                  std::span<const PlacedBlock> blocks, FieldLanes& lanes, float* bounds,
                  FieldReadings* readings) {
  const F f;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const PlacedBlock& block = blocks[b];
    for (std::size_t k = 0; k < kBlockPlaces; k += kWidth) {
      const Lanes3 place{hn::LoadU(f, block.places_F.x + k), hn::LoadU(f, block.places_F.y + k),
                         hn::LoadU(f, block.places_F.z + k)};
      const auto along = [&](std::size_t axis) HWY_ATTR {
        return hn::Add(hn::Set(f, block.from_base[axis]), Dot(Broadcast(&R_VF[3 * axis]), place));
      };
      Find(field, block.base, {along(0), along(1), along(2)}, kBlockPlaces * b + k, lanes);
    }
  }
  ReadAll(field, kBlockPlaces * blocks.size(), lanes);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    readings[b] = Sum(field, reach, kBlockPlaces * b, lanes, bounds + kBlockPlaces * b);
  }
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

namespace {
HWY_EXPORT(LookUpAll);
HWY_EXPORT(LookUpBlocks);
}  // namespace

FieldView DistanceField::View() const noexcept {
  FieldView view;
  view.hyperbricks = hyperbricks_.data();
  view.first_bricks = first_bricks_.data();
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
  const FieldView view = View();
  FieldLanes lanes;
  for (std::size_t begin = 0; begin < count; begin += FieldLanes::kMost) {
    const std::size_t together = std::min(FieldLanes::kMost, count - begin);
    HWY_DYNAMIC_DISPATCH(LookUpAll)
    (view, base, {places.x + begin, places.y + begin, places.z + begin}, together, lanes);
    std::copy_n(lanes.value.data(), together, values + begin);
    std::copy_n(lanes.kind.data(), together, kinds + begin);
    if (over != nullptr) std::copy_n(lanes.over.data(), together, over + begin);
  }
}

void DistanceField::ReadBlocks(const std::array<float, 9>& R_VF, float reach,
                               std::span<const PlacedBlock> blocks, float* bounds,
                               FieldReadings* readings) const noexcept {
  constexpr std::size_t kTogether = FieldLanes::kMost / kBlockPlaces;
  const FieldView view = View();
  FieldLanes lanes;
  for (std::size_t begin = 0; begin < blocks.size(); begin += kTogether) {
    const auto some = blocks.subspan(begin, std::min(kTogether, blocks.size() - begin));
    HWY_DYNAMIC_DISPATCH(LookUpBlocks)
    (view, R_VF, reach, some, lanes, bounds + kBlockPlaces * begin, readings + begin);
    AskLists(lanes, reach, some, bounds + kBlockPlaces * begin, readings + begin);
  }
}

}  // namespace tandem
#endif
