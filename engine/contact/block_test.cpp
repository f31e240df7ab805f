#include "engine/contact/block_test.h"

#include <algorithm>
#include <bit>

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/contact/block_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kLanes = PointBlocks::kLanes;
// blocks under way at once: what one stage stores the next reads several hundred instructions later
constexpr std::size_t kBatch = 8;

using F = hn::CappedTag<float, kLanes>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;

/// One block between the stages.
struct alignas(64) Stage {
  std::array<std::int32_t, kLanes> x, y, z;  // voxel of V
  std::array<std::uint32_t, kLanes> chunk;   // the same for lanes in one chunk
  std::array<std::uint32_t, kLanes> byte;    // of the voxel's mark in its chunk's plane
  std::array<std::uint32_t, kLanes> shift;   // of the mark in that byte
  std::array<std::uint32_t, kLanes> plane;
  std::array<std::uint64_t, kLanes> address;  // of that byte, from the first plane
  std::array<std::uint8_t, kLanes> stored;    // that byte
  unsigned inside;                            // lanes in the map's box
};

/// What the kernel reads of a voxmap, in registers.
struct MapView {
  explicit MapView(const Voxmap& voxmap)
      : map(&voxmap),
        planes(voxmap.planes()),
        bits_log2(std::countr_zero(voxmap.header().bits)),
        plane_log2(std::countr_zero(static_cast<unsigned>(voxmap.plane_bytes()))),
        largest_mark((1U << voxmap.header().bits) - 1),
        beyond(static_cast<std::uint32_t>(voxmap.beyond())) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      last[axis] = static_cast<std::int32_t>(voxmap.header().size[axis] * kHyperchunkSide) - 1;
    }
  }
  const Voxmap* map;
  const std::uint8_t* planes;
  int bits_log2;
  int plane_log2;
  std::uint32_t largest_mark;
  std::uint32_t beyond;
  std::array<std::int32_t, 3> last{};  // voxel of the box
};

template <class D, class Mask>
unsigned MaskBits(D d, Mask mask) {
  alignas(8) std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(d, mask, bytes.data());
  return bytes[0] | static_cast<unsigned>(bytes[1]) << 8U;
}

using Floats = hn::Vec<F>;
using Ints = hn::Vec<I>;

struct VoxelLanes {
  Ints x, y, z;
};

/// The voxels of V that some of a block's points lie in.
VoxelLanes VoxelsOf(const PointBlocks& blocks, const VoxelTransform& transform, std::uint32_t block,
                    std::size_t lane) {
  const F df;
  const I di;
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
  // never fused: every processor must find the same voxel
  const auto row = [&](std::size_t r) HWY_ATTR {
    const Floats along_xy =
        hn::Add(hn::Mul(hn::Set(df, a[3 * r]), x), hn::Mul(hn::Set(df, a[3 * r + 1]), y));
    const Floats along = hn::Add(along_xy, hn::Mul(hn::Set(df, a[3 * r + 2]), z));
    return hn::ConvertTo(di, hn::Floor(hn::Add(along, hn::Set(df, b[r]))));
  };
  return {row(0), row(1), row(2)};
}

/// Place in its chunk of each voxel.
hn::Vec<U> CellsOf(const VoxelLanes& voxels) {
  const U du;
  const auto low = [&](Ints i) HWY_ATTR {
    return hn::And(hn::BitCast(du, i), hn::Set(du, 7U));
  };
  return hn::Or(low(voxels.x),
                hn::Or(hn::ShiftLeft<3>(low(voxels.y)), hn::ShiftLeft<6>(low(voxels.z))));
}

/// Voxels of a block's points.
void Place(const PointBlocks& blocks, const VoxelTransform& transform, const MapView& view,
           std::uint32_t block, Stage& stage) {
  const I di;
  const U du;
  stage.inside = 0;
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(di)) {
    const VoxelLanes voxels = VoxelsOf(blocks, transform, block, lane);
    const auto [ix, iy, iz] = voxels;
    hn::Store(ix, di, &stage.x[lane]);
    hn::Store(iy, di, &stage.y[lane]);
    hn::Store(iz, di, &stage.z[lane]);
    const auto below = hn::Lt(hn::Or(hn::Or(ix, iy), iz), hn::Zero(di));
    const auto above =
        hn::Or(hn::Or(hn::Gt(ix, hn::Set(di, view.last[0])), hn::Gt(iy, hn::Set(di, view.last[1]))),
               hn::Gt(iz, hn::Set(di, view.last[2])));
    stage.inside |= (~MaskBits(di, hn::Or(below, above)) & ((1U << hn::Lanes(di)) - 1)) << lane;

    const auto ux = hn::BitCast(du, ix);
    const auto uy = hn::BitCast(du, iy);
    const auto uz = hn::BitCast(du, iz);
    // a block is far less than 2^10 chunks long, so no two of its chunks share these bits
    const auto low = hn::Set(du, 0x3ffU);
    const auto chunk = hn::Or(hn::And(hn::ShiftRight<3>(ux), low),
                              hn::Or(hn::ShiftLeft<10>(hn::And(hn::ShiftRight<3>(uy), low)),
                                     hn::ShiftLeft<20>(hn::And(hn::ShiftRight<3>(uz), low))));
    hn::Store(chunk, du, &stage.chunk[lane]);
    const auto bit = hn::ShiftLeftSame(CellsOf(voxels), view.bits_log2);
    hn::Store(hn::ShiftRight<3>(bit), du, &stage.byte[lane]);
    hn::Store(hn::And(bit, hn::Set(du, 7U)), du, &stage.shift[lane]);
    hn::Store(hn::Zero(du), du, &stage.plane[lane]);  // beyond
  }
}

/// Where the marks of a block's points lie: one look-up for each chunk that its points are in,
/// which are one to three as a rule.
void Resolve(const MapView& view, Field field, Stage& stage) {
  const U du;
  for (unsigned left = stage.inside; left != 0;) {
    const auto first = static_cast<std::size_t>(std::countr_zero(left));
    const std::uint32_t plane =
        view.map->PlaneOf(field, GridIndex{stage.x[first], stage.y[first], stage.z[first]} >> 3);
    const auto wanted = hn::Set(du, stage.chunk[first]);
    const auto found = hn::Set(du, plane);
    for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(du)) {
      const auto same = hn::Eq(hn::Load(du, &stage.chunk[lane]), wanted);
      hn::BlendedStore(found, same, du, &stage.plane[lane]);
      left &= ~(MaskBits(du, same) << lane);
    }
  }
  if (stage.inside != (1U << kLanes) - 1) {  // those outside may share a chunk's bits with others
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if ((stage.inside >> lane & 1) == 0) stage.plane[lane] = kPlaneBeyond;
    }
  }
  const hn::CappedTag<std::uint64_t, kLanes> dw;
  const hn::Rebind<std::uint32_t, decltype(dw)> dn;
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(dw)) {
    const auto plane = hn::PromoteTo(dw, hn::Load(dn, &stage.plane[lane]));
    const auto byte = hn::PromoteTo(dw, hn::Load(dn, &stage.byte[lane]));
    hn::Store(hn::Add(hn::ShiftLeftSame(plane, view.plane_log2), byte), dw, &stage.address[lane]);
  }
}

BlockReading Read(const MapView& view, int threshold, unsigned lanes, Stage& stage) {
  const I di;
  const U du;
  const hn::Rebind<std::uint8_t, U> db;
  unsigned contacts = 0;
  auto least = hn::Set(di, 255);
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(du)) {
    const auto bytes = hn::PromoteTo(du, hn::Load(db, &stage.stored[lane]));
    const auto mark =
        hn::And(hn::Shr(bytes, hn::Load(du, &stage.shift[lane])), hn::Set(du, view.largest_mark));
    const auto read =
        hn::BitCast(di, hn::IfThenElse(hn::Eq(mark, hn::Zero(du)), hn::Set(du, view.beyond), mark));
    least = hn::Min(least, read);
    contacts |= MaskBits(di, hn::Lt(read, hn::Set(di, threshold + 1))) << lane;
  }
  return {static_cast<std::uint16_t>(contacts & lanes),
          static_cast<std::uint8_t>(hn::GetLane(hn::MinOfLanes(di, least)))};
}

void TestBlocks(const PointBlocks& blocks, const VoxelTransform& transform, const Voxmap& voxmap,
                int threshold, std::span<const std::uint32_t> list, BlockReading* readings) {
  const MapView view(voxmap);
  std::array<Stage, kBatch> stages;
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
    for (std::size_t k = 0; k < count; ++k) Resolve(view, blocks.fields()[batch[k]], stages[k]);
    for (std::size_t k = 0; k < count; ++k) {
      Stage& stage = stages[k];
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        stage.stored[lane] = view.planes[stage.address[lane]];
      }
    }
    for (std::size_t k = 0; k < count; ++k) {
      const unsigned lanes = (1U << blocks.counts()[batch[k]]) - 1;
      readings[begin + k] = Read(view, threshold, lanes, stages[k]);
    }
  }
}

void TransformBlocks(const PointBlocks& blocks, const VoxelTransform& transform, int threshold,
                     std::span<const std::uint32_t> list, BlockReading* readings) {
  const I di;
  for (const std::uint32_t block : list) {
    unsigned contacts = 0;
    auto least = hn::Set(di, 255);
    for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(di)) {
      const auto cells = hn::BitCast(di, CellsOf(VoxelsOf(blocks, transform, block, lane)));
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
