#include "app/bench/reference/gathered_lookup.h"

#include <algorithm>
#include <array>
#include <bit>

#include <hwy/cache_control.h>

#include "engine/base/check.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "app/bench/reference/gathered_lookup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kGroup = 16;
// groups between the stages: far enough that prefetched data have arrived
constexpr std::size_t kToSlice = 2;
constexpr std::size_t kToPlane = 4;
constexpr std::size_t kToQuarter = 6;
constexpr std::size_t kToMark = 10;
constexpr std::size_t kRing = 16;  // > kToMark

struct alignas(64) Group {
  std::array<std::uint32_t, kGroup> hyperchunk;
  std::array<std::uint32_t, kGroup> chunk;  // in its hyperchunk
  std::array<std::uint32_t, kGroup> part;   // the voxel's quarter of its chunk
  std::array<std::uint32_t, kGroup> bit;    // bit of its mark in that quarter
  std::array<const VoxmapRecord*, kGroup> record;
  std::array<const std::uint32_t*, kGroup> quarter;
  std::array<const std::uint8_t*, kGroup> byte;
};

struct MapView {
  explicit MapView(const Voxmap& voxmap, Field read)
      : index(voxmap.index()),
        records(voxmap.records()),
        planes(voxmap.planes()),
        quarters(voxmap.quarters()),
        quarter_log2(std::countr_zero(static_cast<unsigned>(voxmap.quarter_bytes()))),
        bits(voxmap.header().bits),
        beyond(static_cast<std::uint8_t>(voxmap.beyond())),
        size(voxmap.header().size),
        field(static_cast<std::size_t>(read)) {}
  const std::uint32_t* index;
  const VoxmapRecord* records;
  const VoxmapPlane* planes;
  const std::uint8_t* quarters;
  int quarter_log2;
  std::uint32_t bits;
  std::uint8_t beyond;
  std::array<std::uint32_t, 3> size;
  std::size_t field;
};

/// Finds the hyperchunk, the chunk, the quarter and the bit of each place of a group. A place
/// outside the map gets the map's first hyperchunk, which belongs to the empty border.
void Locate(const VoxelPlaces& places, const MapView& view, std::size_t first, Group& group) {
  const hn::CappedTag<float, kGroup> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::RebindToUnsigned<decltype(df)> du;
  const auto last = [&](std::size_t axis) HWY_ATTR {
    return hn::Set(di, static_cast<std::int32_t>(view.size[axis] * kHyperchunkSide) - 1);
  };
  for (std::size_t lane = 0; lane < kGroup; lane += hn::Lanes(df)) {
    const auto ix = hn::ConvertTo(di, hn::Floor(hn::LoadU(df, &places.x[first + lane])));
    const auto iy = hn::ConvertTo(di, hn::Floor(hn::LoadU(df, &places.y[first + lane])));
    const auto iz = hn::ConvertTo(di, hn::Floor(hn::LoadU(df, &places.z[first + lane])));
    const auto below = hn::Lt(hn::Or(hn::Or(ix, iy), iz), hn::Zero(di));
    const auto above =
        hn::Or(hn::Or(hn::Gt(ix, last(0)), hn::Gt(iy, last(1))), hn::Gt(iz, last(2)));
    const auto zeroed = [&](auto i) HWY_ATTR {
      return hn::BitCast(du, hn::IfThenZeroElse(hn::Or(below, above), i));
    };
    const auto x = zeroed(ix);
    const auto y = zeroed(iy);
    const auto z = zeroed(iz);
    const auto row =
        hn::Add(hn::ShiftRight<6>(y), hn::Mul(hn::Set(du, view.size[1]), hn::ShiftRight<6>(z)));
    hn::Store(hn::Add(hn::ShiftRight<6>(x), hn::Mul(hn::Set(du, view.size[0]), row)), du,
              &group.hyperchunk[lane]);
    const auto cell = [&](auto a, auto b, auto c) HWY_ATTR {
      const auto seven = hn::Set(du, 7U);
      return hn::Or(hn::And(a, seven), hn::Or(hn::ShiftLeft<3>(hn::And(b, seven)),
                                              hn::ShiftLeft<6>(hn::And(c, seven))));
    };
    hn::Store(cell(hn::ShiftRight<3>(x), hn::ShiftRight<3>(y), hn::ShiftRight<3>(z)), du,
              &group.chunk[lane]);
    const auto three = hn::Set(du, 3U);
    const auto four = hn::Set(du, 4U);
    const auto in_quarter =
        hn::Or3(hn::And(x, hn::Set(du, 7U)), hn::ShiftLeft<3>(hn::And(y, three)),
                hn::ShiftLeft<5>(hn::And(z, three)));
    hn::Store(hn::Mul(in_quarter, hn::Set(du, view.bits)), du, &group.bit[lane]);
    hn::Store(hn::Or(hn::ShiftRight<2>(hn::And(y, four)), hn::ShiftRight<1>(hn::And(z, four))), du,
              &group.part[lane]);
  }
  for (std::size_t lane = 0; lane < kGroup; ++lane) {
    hwy::Prefetch(&view.index[group.hyperchunk[lane]]);
  }
}

void FindRecords(const MapView& view, Group& group) {
  for (std::size_t lane = 0; lane < kGroup; ++lane) {
    group.record[lane] = &view.records[view.index[group.hyperchunk[lane]]];
    hwy::Prefetch(&group.record[lane]->slices[view.field][group.chunk[lane] >> 6]);
  }
}

void FindPlanes(const MapView& view, Group& group) {
  for (std::size_t lane = 0; lane < kGroup; ++lane) {
    const std::size_t chunk = group.chunk[lane];
    const VoxmapSlice& slice = group.record[lane]->slices[view.field][chunk >> 6];
    const std::uint64_t bit = std::uint64_t{1} << (chunk & 63);
    std::size_t plane =
        slice.first_plane + static_cast<std::uint32_t>(std::popcount(slice.stored & (bit - 1)));
    if ((slice.stored & bit) == 0) {
      const bool solid = view.field == 0 && (group.record[lane]->solid[chunk >> 6] & bit) != 0;
      plane = solid ? kPlaneInterior : kPlaneBeyond;
    }
    group.quarter[lane] = &view.planes[plane].quarters[group.part[lane]];
    hwy::Prefetch(group.quarter[lane]);
  }
}

void FindBytes(const MapView& view, Group& group) {
  for (std::size_t lane = 0; lane < kGroup; ++lane) {
    group.byte[lane] = view.quarters + (std::uint64_t{*group.quarter[lane]} << view.quarter_log2) +
                       (group.bit[lane] >> 3);
    hwy::Prefetch(group.byte[lane]);
  }
}

void ReadMarks(const MapView& view, const Group& group, std::uint8_t* marks) {
  alignas(16) std::array<std::uint8_t, kGroup> bytes;
  for (std::size_t lane = 0; lane < kGroup; ++lane) bytes[lane] = *group.byte[lane];
  const hn::CappedTag<std::uint32_t, kGroup> du;
  const hn::Rebind<std::uint8_t, decltype(du)> db;
  for (std::size_t lane = 0; lane < kGroup; lane += hn::Lanes(du)) {
    const auto byte = hn::PromoteTo(du, hn::Load(db, &bytes[lane]));
    const auto shift = hn::And(hn::Load(du, &group.bit[lane]), hn::Set(du, 7U));
    const auto mark = hn::And(hn::Shr(byte, shift), hn::Set(du, (1U << view.bits) - 1));
    const auto read = hn::IfThenElse(hn::Eq(mark, hn::Zero(du)), hn::Set(du, view.beyond), mark);
    hn::StoreU(hn::DemoteTo(db, hn::BitCast(hn::RebindToSigned<decltype(du)>(), read)), db,
               marks + lane);
  }
}

void TestWholeGroups(const VoxelPlaces& places, const MapView& view, std::uint8_t* marks) {
  const std::size_t groups = places.x.size() / kGroup;
  std::array<Group, kRing> ring;
  for (std::size_t g = 0; g < groups + kToMark; ++g) {
    if (g < groups) Locate(places, view, g * kGroup, ring[g % kRing]);
    if (g >= kToSlice && g - kToSlice < groups) FindRecords(view, ring[(g - kToSlice) % kRing]);
    if (g >= kToPlane && g - kToPlane < groups) FindPlanes(view, ring[(g - kToPlane) % kRing]);
    if (g >= kToQuarter && g - kToQuarter < groups) FindBytes(view, ring[(g - kToQuarter) % kRing]);
    if (g >= kToMark) ReadMarks(view, ring[(g - kToMark) % kRing], marks + (g - kToMark) * kGroup);
  }
}

void TestScattered(const VoxelPlaces& places, const Voxmap& voxmap, Field field,
                   std::uint8_t* marks) {
  const MapView view(voxmap, field);
  TestWholeGroups(places, view, marks);
  const std::size_t done = places.x.size() / kGroup * kGroup;
  if (done == places.x.size()) return;
  // the rest, filled up to a group
  std::array<std::array<float, kGroup>, 3> rest{};
  std::array<std::uint8_t, kGroup> read{};
  const std::size_t left = places.x.size() - done;
  std::copy_n(places.x.begin() + static_cast<std::ptrdiff_t>(done), left, rest[0].begin());
  std::copy_n(places.y.begin() + static_cast<std::ptrdiff_t>(done), left, rest[1].begin());
  std::copy_n(places.z.begin() + static_cast<std::ptrdiff_t>(done), left, rest[2].begin());
  TestWholeGroups({rest[0], rest[1], rest[2]}, view, read.data());
  std::copy_n(read.begin(), left, marks + done);
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

HWY_EXPORT(TestScattered);

void TestScattered(const VoxelPlaces& places, const Voxmap& voxmap, Field field,
                   std::uint8_t* marks) noexcept {
  TANDEM_CHECK(places.y.size() == places.x.size() && places.z.size() == places.x.size());
  HWY_DYNAMIC_DISPATCH(TestScattered)(places, voxmap, field, marks);
}

}  // namespace tandem
#endif
