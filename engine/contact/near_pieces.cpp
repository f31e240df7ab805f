#include "engine/contact/near_pieces.h"

#include <algorithm>
#include <bit>

#include "engine/contact/edge_contact.h"
#include "engine/contact/surface_window.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/contact/near_pieces.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, NearPieces::kLanes>;
using Words = hn::RebindToUnsigned<Lanes>;
using Ints = hn::RebindToSigned<Lanes>;

/// As UnpackDirection(), of 16 bits each.
void StoreDirection(hn::Vec<Words> packed, std::size_t lane, NearPieces::Rows& rows) {
  const Lanes d;
  const Ints di;
  const auto scale = hn::Set(d, 1.0F / 32767.0F);
  const auto one = hn::Set(d, 1.0F);
  const auto bits = hn::BitCast(di, packed);
  const auto u = hn::Mul(scale, hn::ConvertTo(d, hn::ShiftRight<16>(hn::ShiftLeft<16>(bits))));
  const auto v = hn::Mul(scale, hn::ConvertTo(d, hn::ShiftRight<16>(bits)));
  const auto z = hn::Sub(hn::Sub(one, hn::Abs(u)), hn::Abs(v));
  const auto folded = hn::Lt(z, hn::Zero(d));
  const auto x = hn::IfThenElse(folded, hn::CopySign(hn::Sub(one, hn::Abs(v)), u), u);
  const auto y = hn::IfThenElse(folded, hn::CopySign(hn::Sub(one, hn::Abs(u)), v), v);
  const auto square = hn::Add(hn::Mul(x, x), hn::Add(hn::Mul(y, y), hn::Mul(z, z)));
  const auto by = hn::Div(one, hn::Sqrt(square));
  hn::Store(hn::Mul(by, x), d, &rows[0][lane]);
  hn::Store(hn::Mul(by, y), d, &rows[1][lane]);
  hn::Store(hn::Mul(by, z), d, &rows[2][lane]);
}

/// Puts pieces into blocks, and fills the gap in the last.
void UnpackPieces(const NearPieces::Packed& packed, NearPieces::Block* blocks) {
  const Lanes d;
  const Words du;
  const Ints di;
  const auto* words = reinterpret_cast<const std::uint32_t*>(packed.details.data());
  const auto* voxels = reinterpret_cast<const std::int32_t*>(packed.voxels.data());
  const std::size_t end = hwy::RoundUpTo(packed.count, NearPieces::kLanes);
  for (std::size_t i = 0; i < end; i += hn::Lanes(d)) {
    NearPieces::Block& block = blocks[i / NearPieces::kLanes];
    const std::size_t lane = i % NearPieces::kLanes;
    hn::Vec<Words> place, normal, tangent;
    hn::LoadInterleaved3(du, words + 3 * i, place, normal, tangent);
    hn::Vec<Ints> vx, vy, vz;
    hn::LoadInterleaved3(di, voxels + 3 * i, vx, vy, vz);
    const auto step = hn::Set(d, 1.0F / 255.0F);
    const auto put = [&](auto voxel, auto byte, std::size_t axis) HWY_ATTR {
      const auto corner = hn::ConvertTo(d, voxel);
      const auto within = hn::ConvertTo(d, hn::BitCast(di, hn::And(byte, hn::Set(du, 255U))));
      hn::Store(hn::Add(corner, hn::Mul(step, within)), d, &block.place[axis][lane]);
      const auto kept = hn::FirstN(d, packed.count - std::min(i, packed.count));
      hn::Store(hn::IfThenElse(kept, corner, hn::Set(d, NearPieces::kFarAway)), d,
                &block.voxel[axis][lane]);
    };
    put(vx, place, 0);
    put(vy, hn::ShiftRight<8>(place), 1);
    put(vz, hn::ShiftRight<16>(place), 2);
    StoreDirection(normal, lane, block.normal);
    StoreDirection(tangent, lane, block.tangent);
  }
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

HWY_EXPORT(UnpackPieces);

namespace {

static_assert(sizeof(SurfaceDetail) == 3 * sizeof(std::uint32_t));
static_assert(sizeof(GridIndex) == 3 * sizeof(std::int32_t));

/// A piece among those of a cell.
struct Slot {
  NearPieces::Block& block;
  std::size_t lane;
  Slot(NearPieces::Block* blocks, std::size_t i)
      : block(blocks[i / NearPieces::kLanes]), lane(i % NearPieces::kLanes) {}

  Vec3f Normal() const { return At(block.normal); }
  Vec3f Tangent() const { return At(block.tangent); }
  void SetNormal(const Vec3f& n) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.normal[axis][lane] = n[static_cast<Eigen::Index>(axis)];
    }
  }
  /// All but the normal.
  void CopyFrom(const Slot& other) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.voxel[axis][lane] = other.block.voxel[axis][other.lane];
      block.place[axis][lane] = other.block.place[axis][other.lane];
      block.tangent[axis][lane] = other.block.tangent[axis][other.lane];
    }
    block.half[lane] = other.block.half[other.lane];
    block.arc_tangent[lane] = other.block.arc_tangent[other.lane];
    block.arc_cosine[lane] = other.block.arc_cosine[other.lane];
    block.arc_last[lane] = other.block.arc_last[other.lane];
  }

 private:
  Vec3f At(const NearPieces::Rows& rows) const {
    return {rows[0][lane], rows[1][lane], rows[2][lane]};
  }
};

static_assert(NearPieces::kCellSide == 4);

/// Of a cell's voxels and a field, never 0.
std::uint64_t KeyOf(const GridIndex& voxel, Field field) {
  constexpr unsigned kBits = 20;
  const auto cell = [](std::int32_t at) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(at >> 2) & ((1U << kBits) - 1));
  };
  return (static_cast<std::uint64_t>(field) + 1) << (3 * kBits) | cell(voxel.z) << (2 * kBits) |
         cell(voxel.y) << kBits | cell(voxel.x);
}

std::uint64_t HashOf(std::uint64_t key) {
  return 0x9e3779b97f4a7c15U * (key ^ key >> 29U) >> 32U;
}

}  // namespace

NearPieces::NearPieces(const Voxmap& voxmap, const SurfaceDetails& details, std::size_t cells)
    : voxmap_(&voxmap),
      details_(&details),
      places_(std::bit_ceil(std::max<std::size_t>(1, cells / 2))),
      blocks_(kBlocksOfCell * cells + 4 * kMostBlocks) {}

const NearPieces::Cell& NearPieces::About(const GridIndex& voxel, Field field) noexcept {
  const std::uint64_t key = KeyOf(voxel, field);
  Place& place = places_[HashOf(key) & (places_.size() - 1)];
  std::size_t oldest = 0;
  for (std::size_t i = 0; i < kWays; ++i) {
    if (place.keys[i] == key && Keeps(place.cells[i])) return place.cells[i];
    if (place.cells[i].at_ < place.cells[oldest].at_) oldest = i;
  }
  place.keys[oldest] = key;
  Find(MiddleOf(voxel), field, place.cells[oldest]);
  return place.cells[oldest];
}

void NearPieces::Find(const GridIndex& middle, Field field, Cell& cell) noexcept {
  if (head_ % blocks_.size() + kMostBlocks > blocks_.size()) {
    head_ += blocks_.size() - head_ % blocks_.size();
  }
  out_ = &blocks_[head_ % blocks_.size()];
  count_ = 0;
  cell.too_many_ = !List(middle, field);
  if (cell.too_many_) plain_.count = of_ridges_.count = of_corners_.count = 0;
  Unpack(plain_);
  if (field == Field::kEdge) SetArcs(plain_);
  if (field != Field::kVertex) AddOtherSides(plain_, 0);
  cell.ridges_ = static_cast<std::uint16_t>(count_ / kLanes);
  const std::size_t ridges = count_;
  Unpack(of_ridges_);
  AddOtherFaces(of_ridges_, ridges);
  cell.corners_ = static_cast<std::uint16_t>(count_ / kLanes);
  const std::size_t corners = count_;
  Unpack(of_corners_);
  AddOtherSides(of_corners_, corners);
  cell.count_ = static_cast<std::uint16_t>(count_ / kLanes);
  cell.blocks_ = out_;
  cell.at_ = head_;
  head_ += cell.count_;
}

bool NearPieces::List(const GridIndex& middle, Field field) noexcept {
  using Shape = SurfaceDetail::Shape;
  plain_.count = of_ridges_.count = of_corners_.count = 0;
  std::size_t count = 0;
  const auto keep = [&](const GridIndex& voxel, const SurfaceDetail& detail, bool /*ends*/) {
    if (++count > kMostSources) return;
    Packed* packed = &plain_;
    if (field == Field::kSurface) {
      const Shape shape = detail.shape();
      if (shape == Shape::kRidge) packed = &of_ridges_;
      if (shape == Shape::kVertex || shape == Shape::kNotch) packed = &of_corners_;
    }
    packed->details[packed->count] = detail;
    packed->voxels[packed->count++] = voxel - middle;
  };
  constexpr int kReach = kCellSide / 2 + 1;
  const GridIndex low = middle - GridIndex{kReach, kReach, kReach};
  const GridIndex high = middle + GridIndex{kReach - 1, kReach - 1, kReach - 1};
  VisitPieces<false>(*voxmap_, *details_, low, high, low, field, keep);
  return count <= kMostSources;
}

void NearPieces::Unpack(const Packed& packed) noexcept {
  HWY_DYNAMIC_DISPATCH(UnpackPieces)(packed, out_ + count_ / kLanes);
  count_ += hwy::RoundUpTo(packed.count, kLanes);
}

void NearPieces::FillBlock() noexcept {
  for (; count_ % kLanes != 0; ++count_) out_[count_ / kLanes].voxel[0][count_ % kLanes] = kFarAway;
}

void NearPieces::AddOtherSides(const Packed& packed, std::size_t first) noexcept {
  for (std::size_t i = 0; i < packed.count; ++i) {
    if (packed.details[i].half_length != SurfaceDetail::kTwoSided) continue;
    const Slot from(out_, first + i);
    const Slot to(out_, count_++);
    to.CopyFrom(from);
    to.SetNormal(-from.Normal());
  }
  FillBlock();
}

void NearPieces::AddOtherFaces(const Packed& packed, std::size_t first) noexcept {
  for (std::size_t i = 0; i < packed.count; ++i) {
    const EdgeArc& arc = ArcOf(packed.details[i]);
    const Slot one(out_, first + i);
    const Slot other(out_, count_++);
    const Vec3f across = static_cast<float>(arc.sine) * one.Tangent().cross(one.Normal());
    const Vec3f along = static_cast<float>(arc.cosine) * one.Normal();
    other.CopyFrom(one);
    one.SetNormal(along + across);
    other.SetNormal(along - across);
  }
  FillBlock();
}

void NearPieces::SetArcs(const Packed& packed) noexcept {
  for (std::size_t i = 0; i < packed.count; ++i) {
    const SurfaceDetail& detail = packed.details[i];
    const EdgeArc& arc = ArcOf(detail);
    const bool two_sided = detail.half_length == SurfaceDetail::kTwoSided;
    Block& block = out_[i / kLanes];
    const std::size_t lane = i % kLanes;
    block.half[lane] = static_cast<float>((two_sided ? 0.5 : detail.half_length / 128.0) + kSeam);
    block.arc_tangent[lane] = static_cast<float>(arc.sine / (1.0 + arc.cosine));
    block.arc_cosine[lane] = static_cast<float>(arc.cosine);
    block.arc_last[lane] = static_cast<float>(arc.last);
  }
}

}  // namespace tandem
#endif
