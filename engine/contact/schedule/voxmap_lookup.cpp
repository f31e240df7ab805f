#include "engine/contact/schedule/voxmap_lookup.h"

#include <algorithm>
#include <bit>

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/contact/schedule/voxmap_lookup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

constexpr std::size_t kLanes = PointBlocks::kLanes;
// blocks in flight at once: the next stage reads a stage's results several hundred instructions
// later
constexpr std::size_t kBatch = 8;

constexpr std::size_t kPart = hn::MaxLanes(F());  // lanes of a vector
static_assert(kLanes % kPart == 0);
constexpr std::size_t kParts = kLanes / kPart;

/// One block between the stages, by lane. Addresses have 32 bits in maps that 32 bits can address.
template <class Address>
struct alignas(64) Stage {
  std::array<std::uint32_t, kLanes> hyperchunk;  // index of the hyperchunk in the map
  std::array<std::uint32_t, kLanes> key;         // the same number for lanes in one chunk
  std::array<std::uint32_t, kLanes> pick;   // byte numbers in a VoxmapPlane: the voxel's quarter
  std::array<std::uint32_t, kLanes> byte;   // byte of the mark in that quarter
  std::array<Address, kLanes> address;      // address of the byte with the mark, from quarter 0
  std::array<std::uint16_t, kLanes> scale;  // brings the mark in that byte to bit 8
  std::array<std::uint8_t, kLanes> stored;  // the byte with the mark
};

/// The parts of a voxmap that the kernel reads, in registers.
struct MapView {
  explicit MapView(const Voxmap& voxmap)
      : index(voxmap.index()),
        records(voxmap.records()),
        size(voxmap.header().size),
        planes(voxmap.planes()),
        quarters(voxmap.quarters()),
        bits_log2(std::countr_zero(voxmap.header().bits)),
        quarter_log2(std::countr_zero(static_cast<unsigned>(voxmap.quarter_bytes()))),
        largest_mark(static_cast<std::uint16_t>((1U << voxmap.header().bits) - 1)),
        beyond(static_cast<std::uint16_t>(voxmap.beyond())) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      last[axis] = static_cast<float>(voxmap.header().size[axis] * kHyperchunkSide) - 0.5F;
    }
  }
  const std::uint32_t* index;
  const VoxmapRecord* records;
  std::array<std::uint32_t, 3> size;  // hyperchunks
  const VoxmapPlane* planes;
  const std::uint8_t* quarters;
  int bits_log2;
  int quarter_log2;
  std::uint16_t largest_mark;
  std::uint16_t beyond;
  std::array<float, 3> last{};  // middle of the box's last voxel
};

/// Returns where some of a block's points are, in voxels of V.
HWY_INLINE Lanes3 PlacesOf(const PointBlocks& blocks, const VoxelTransform& transform,
                           std::uint32_t block, std::size_t lane) {
  const F df;
  const PointBlocks::Lanes& p = blocks.positions()[block];
  const auto& a = transform.a;
  const auto& b = transform.b;
  Floats x = hn::Load(df, &p.x[lane]);
  Floats y = hn::Load(df, &p.y[lane]);
  Floats z = hn::Load(df, &p.z[lane]);
  if (transform.displacement != 0) {
    const PointBlocks::Lanes& n = blocks.normals()[block];
    const Floats shift = hn::Set(df, transform.displacement);
    x = hn::Add(x, hn::Mul(shift, hn::Load(df, &n.x[lane])));
    y = hn::Add(y, hn::Mul(shift, hn::Load(df, &n.y[lane])));
    z = hn::Add(z, hn::Mul(shift, hn::Load(df, &n.z[lane])));
  }
  const auto row = [&](std::size_t r) HWY_ATTR {
    return hn::Add(Dot(Broadcast(&a[3 * r]), {x, y, z}), hn::Set(df, b[r]));
  };
  return {row(0), row(1), row(2)};
}

/// Returns the voxels of V at places. A place outside the box gets its outermost voxels,
/// which belong to its empty border.
HWY_INLINE IntLanes3 VoxelsAt(const Lanes3& places, const std::array<float, 3>& last) {
  const F df;
  const auto within = [&](Floats p, float most) HWY_ATTR {
    const Floats clamped = hn::Min(hn::Max(p, hn::Zero(df)), hn::Set(df, most));
    return hn::ConvertTo(I(), clamped);
  };
  return {within(places.x, last[0]), within(places.y, last[1]), within(places.z, last[2])};
}

/// Returns numbers of places in cubes of 8 x 8 x 8.
HWY_INLINE Uints CellsOf(Uints x, Uints y, Uints z) {
  const auto low = [](Uints i) HWY_ATTR {
    return hn::And(i, hn::Set(U(), 7U));
  };
  return hn::Or(low(x), hn::Or(hn::ShiftLeft<3>(low(y)), hn::ShiftLeft<6>(low(z))));
}

/// As Voxmap::PlaneOf, without a branch on what the chunk stores: free space and surfaces alternate
/// along a pointshell.
HWY_INLINE std::uint32_t PlaneOf(const MapView& view, Field field, std::uint32_t hyperchunk,
                                 std::uint32_t chunk) {
  const VoxmapRecord& record = view.records[view.index[hyperchunk]];
  const VoxmapSlice& slice = record.slices[static_cast<std::size_t>(field)][chunk >> 6];
  const std::uint64_t bit = std::uint64_t{1} << (chunk & 63);
  const std::uint32_t plane =
      slice.first_plane + static_cast<std::uint32_t>(std::popcount(slice.stored & (bit - 1)));
  static_assert(kPlaneInterior == 1 && kPlaneBeyond == 0);
  const std::uint64_t solid = field == Field::kSurface ? record.solid[chunk >> 6] : 0;
  const std::uint32_t uniform = (solid & bit) != 0 ? kPlaneInterior : kPlaneBeyond;
  return (slice.stored & bit) != 0 ? plane : uniform;
}

/// Returns the numbers of the quarters that lanes pick from a plane.
HWY_INLINE Uints QuartersOf(const VoxmapPlane& plane, Uints pick) {
#if HWY_TARGET == HWY_SCALAR
  return hn::Set(U(), plane.quarters[hn::GetLane(pick) >> 2U & 3U]);
#else
  return hn::TableLookupBytes(hn::LoadDup128(U(), plane.quarters.data()), pick);
#endif
}

/// Stores addresses of marks, from their quarters and their bytes in these.
HWY_INLINE void StoreAddresses(const std::array<Uints, kParts>& quarters,
                               const std::array<Uints, kParts>& bytes, const MapView& view,
                               std::array<std::uint32_t, kLanes>& out) {
  for (std::size_t part = 0; part < kParts; ++part) {
    hn::Store(hn::Add(hn::ShiftLeftSame(quarters[part], view.quarter_log2), bytes[part]), U(),
              &out[part * kPart]);
  }
}
HWY_INLINE void StoreAddresses(const std::array<Uints, kParts>& quarters,
                               const std::array<Uints, kParts>& bytes, const MapView& view,
                               std::array<std::uint64_t, kLanes>& out) {
  alignas(64) std::array<std::uint32_t, kLanes> quarter;
  alignas(64) std::array<std::uint32_t, kLanes> byte;
  for (std::size_t part = 0; part < kParts; ++part) {
    hn::Store(quarters[part], U(), &quarter[part * kPart]);
    hn::Store(bytes[part], U(), &byte[part * kPart]);
  }
  const hn::CappedTag<std::uint64_t, kLanes> dw;
  const hn::Rebind<std::uint32_t, decltype(dw)> dn;
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(dw)) {
    const auto wide = hn::PromoteTo(dw, hn::Load(dn, &quarter[lane]));
    const auto within = hn::PromoteTo(dw, hn::Load(dn, &byte[lane]));
    hn::Store(hn::Add(hn::ShiftLeftSame(wide, view.quarter_log2), within), dw, &out[lane]);
  }
}

/// Finds where in the map's levels a block's points are.
template <class Address>
HWY_INLINE void Place(const PointBlocks& blocks, const VoxelTransform& transform,
                      const MapView& view, std::uint32_t block, Stage<Address>& stage) {
  const I di;
  const U du;
  const hn::Rebind<std::uint16_t, I> dh;
  for (std::size_t lane = 0; lane < kLanes; lane += kPart) {
    const IntLanes3 voxels = VoxelsAt(PlacesOf(blocks, transform, block, lane), view.last);
    const Uints x = hn::BitCast(du, voxels.x);
    const Uints y = hn::BitCast(du, voxels.y);
    const Uints z = hn::BitCast(du, voxels.z);
    const Uints row =
        hn::Add(hn::ShiftRight<6>(y), hn::Mul(hn::Set(du, view.size[1]), hn::ShiftRight<6>(z)));
    const Uints place = hn::Add(hn::ShiftRight<6>(x), hn::Mul(hn::Set(du, view.size[0]), row));
    const Uints chunk = CellsOf(hn::ShiftRight<3>(x), hn::ShiftRight<3>(y), hn::ShiftRight<3>(z));
    hn::Store(place, du, &stage.hyperchunk[lane]);
    // no two hyperchunks of one block lie 2^23 apart in the index
    hn::Store(hn::Or(chunk, hn::ShiftLeft<9>(place)), du, &stage.key[lane]);
    // CellInQuarter(); and QuarterOf(), whose number has four bytes
    const Uints three = hn::Set(du, 3U);
    const Uints four = hn::Set(du, 4U);
    const Uints cell = hn::Or3(hn::And(x, hn::Set(du, 7U)), hn::ShiftLeft<3>(hn::And(y, three)),
                               hn::ShiftLeft<5>(hn::And(z, three)));
    const Uints first = hn::Or(hn::And(y, four), hn::ShiftLeft<1>(hn::And(z, four)));
    hn::Store(hn::Or(hn::Mul(first, hn::Set(du, 0x01010101U)), hn::Set(du, 0x03020100U)), du,
              &stage.pick[lane]);
    const Uints bit = hn::ShiftLeftSame(cell, view.bits_log2);
    hn::Store(hn::ShiftRight<3>(bit), du, &stage.byte[lane]);
    const Uints scale = hn::Shr(hn::Set(du, 256U), hn::And(bit, hn::Set(du, 7U)));
    hn::Store(hn::DemoteTo(dh, hn::BitCast(di, scale)), dh, &stage.scale[lane]);
  }
}

/// Finds where the marks of a block's points lie: one look-up for each chunk that its points are
/// in, usually one to four.
template <class Address>
HWY_INLINE void Locate(const MapView& view, Field field, Stage<Address>& stage) {
  const U du;
  std::array<Uints, kParts> keys;
  std::array<Uints, kParts> picks;
  std::array<Uints, kParts> bytes;
  std::array<Uints, kParts> quarters;
  for (std::size_t part = 0; part < kParts; ++part) {
    keys[part] = hn::Load(du, &stage.key[part * kPart]);
    picks[part] = hn::Load(du, &stage.pick[part * kPart]);
    bytes[part] = hn::Load(du, &stage.byte[part * kPart]);
    quarters[part] = hn::Zero(du);
  }
  for (unsigned left = (1U << kLanes) - 1; left != 0;) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    const VoxmapPlane& plane =
        view.planes[PlaneOf(view, field, stage.hyperchunk[lane], stage.key[lane] & 511U)];
    const Uints wanted = hn::Set(du, stage.key[lane]);
    for (std::size_t part = 0; part < kParts; ++part) {
      const auto same = hn::Eq(keys[part], wanted);
      quarters[part] = hn::IfThenElse(same, QuartersOf(plane, picks[part]), quarters[part]);
      left &= ~(MaskBits(du, same) << part * kPart);
    }
  }
  StoreAddresses(quarters, bytes, view, stage.address);
}

template <class Address>
HWY_INLINE BlockReading Read(const MapView& view, int threshold, unsigned lanes,
                             const Stage<Address>& stage) {
  const hn::CappedTag<std::uint16_t, 8> dh;
  const hn::RebindToSigned<decltype(dh)> di;
  const hn::Rebind<std::uint8_t, decltype(dh)> db;
  unsigned contacts = 0;
  auto least = hn::Set(dh, 255);
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(dh)) {
    const auto byte = hn::PromoteTo(dh, hn::Load(db, &stage.stored[lane]));
    const auto mark = hn::And(hn::ShiftRight<8>(hn::Mul(byte, hn::Load(dh, &stage.scale[lane]))),
                              hn::Set(dh, view.largest_mark));
    const auto read = hn::IfThenElse(hn::Eq(mark, hn::Zero(dh)), hn::Set(dh, view.beyond), mark);
    least = hn::Min(least, read);
    const auto below =
        hn::Lt(hn::BitCast(di, read), hn::Set(di, static_cast<std::int16_t>(threshold + 1)));
    contacts |= MaskBits(di, below) << lane;
  }
  return {static_cast<std::uint16_t>(contacts & lanes),
          static_cast<std::uint8_t>(hn::GetLane(hn::MinOfLanes(dh, least)))};
}

template <class Address>
void TestBlocksWith(const PointBlocks& blocks, const VoxelTransform& transform, const MapView& view,
                    int threshold, std::span<const std::uint32_t> list, BlockReading* readings) {
  std::array<Stage<Address>, kBatch> stages;
  for (std::size_t begin = 0; begin < list.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, list.size() - begin);
    const std::span<const std::uint32_t> batch = list.subspan(begin, count);
    for (std::size_t k = begin + kBatch; k < std::min(begin + 2 * kBatch, list.size()); ++k) {
      const PointBlocks::Lanes* next = &blocks.positions()[list[k]];
      hwy::Prefetch(&next->x);
      hwy::Prefetch(&next->y);
      hwy::Prefetch(&next->z);
    }
    for (std::size_t k = 0; k < count; ++k) Place(blocks, transform, view, batch[k], stages[k]);
    for (std::size_t k = 0; k < count; ++k) {
      Locate(view, blocks.fields()[batch[k]], stages[k]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        stages[k].stored[lane] = view.quarters[stages[k].address[lane]];
      }
    }
    for (std::size_t k = 0; k < count; ++k) {
      const unsigned lanes = (1U << blocks.counts()[batch[k]]) - 1;
      readings[begin + k] = Read(view, threshold, lanes, stages[k]);
    }
  }
}

void TestBlocks(const PointBlocks& blocks, const VoxelTransform& transform, const Voxmap& voxmap,
                int threshold, std::span<const std::uint32_t> list, BlockReading* readings) {
  const MapView view(voxmap);
  if (voxmap.header().bytes >> 32U == 0) {
    TestBlocksWith<std::uint32_t>(blocks, transform, view, threshold, list, readings);
  } else {
    TestBlocksWith<std::uint64_t>(blocks, transform, view, threshold, list, readings);
  }
}

void TransformBlocks(const PointBlocks& blocks, const VoxelTransform& transform, int threshold,
                     std::span<const std::uint32_t> list, BlockReading* readings) {
  const I di;
  for (const std::uint32_t block : list) {
    unsigned contacts = 0;
    auto least = hn::Set(di, 255);
    for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(di)) {
      const Lanes3 p = PlacesOf(blocks, transform, block, lane);
      const IntLanes3 voxels{hn::ConvertTo(di, hn::Floor(p.x)), hn::ConvertTo(di, hn::Floor(p.y)),
                             hn::ConvertTo(di, hn::Floor(p.z))};
      const auto cells =
          hn::BitCast(di, CellsOf(hn::BitCast(U(), voxels.x), hn::BitCast(U(), voxels.y),
                                  hn::BitCast(U(), voxels.z)));
      least = hn::Min(least, cells);
      contacts |= MaskBits(di, hn::Lt(cells, hn::Set(di, threshold + 1))) << lane;
    }
    const unsigned lanes = (1U << blocks.counts()[block]) - 1;
    *readings++ = {static_cast<std::uint16_t>(contacts & lanes),
                   static_cast<std::uint8_t>(hn::GetLane(hn::MinOfLanes(di, least)))};
  }
}

const char* KernelIsa() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

HWY_EXPORT(TestBlocks);
HWY_EXPORT(TransformBlocks);
HWY_EXPORT(KernelIsa);

VoxelTransform::VoxelTransform(const Pose& X_VS, double voxel_size, double shift)
    : displacement(static_cast<float>(shift)) {
  const Mat3 R = X_VS.q.toRotationMatrix() / voxel_size;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      a[static_cast<std::size_t>(3 * row + col)] = static_cast<float>(R(row, col));
    }
    b[static_cast<std::size_t>(row)] = static_cast<float>(X_VS.p[row] / voxel_size);
  }
}

std::array<float, 3> VoxelTransform::operator()(const PointBlocks& blocks, std::size_t block,
                                                std::size_t lane) const noexcept {
  const PointBlocks::Lanes& p = blocks.positions()[block];
  float x = p.x[lane];
  float y = p.y[lane];
  float z = p.z[lane];
  if (displacement != 0) {
    const PointBlocks::Lanes& n = blocks.normals()[block];
    x = x + displacement * n.x[lane];
    y = y + displacement * n.y[lane];
    z = z + displacement * n.z[lane];
  }
  return {((a[0] * x + a[1] * y) + a[2] * z) + b[0], ((a[3] * x + a[4] * y) + a[5] * z) + b[1],
          ((a[6] * x + a[7] * y) + a[8] * z) + b[2]};
}

void TestBlocks(const PointBlocks& blocks, const VoxelTransform& transform, const Voxmap& voxmap,
                int threshold, std::span<const std::uint32_t> list,
                BlockReading* readings) noexcept {
  HWY_DYNAMIC_DISPATCH(TestBlocks)(blocks, transform, voxmap, threshold, list, readings);
}

void TransformBlocks(const PointBlocks& blocks, const VoxelTransform& transform, int threshold,
                     std::span<const std::uint32_t> list, BlockReading* readings) noexcept {
  HWY_DYNAMIC_DISPATCH(TransformBlocks)(blocks, transform, threshold, list, readings);
}

const char* KernelIsa() noexcept {
  return HWY_DYNAMIC_DISPATCH(KernelIsa)();
}

}  // namespace tandem
#endif
