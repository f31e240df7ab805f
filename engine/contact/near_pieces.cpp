#include "engine/contact/near_pieces.h"

#include <algorithm>

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
void StoreDirection(hn::Vec<Words> packed, std::size_t at, NearPieces::Columns& columns) {
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
  hn::Store(hn::Mul(by, x), d, &columns[0][at]);
  hn::Store(hn::Mul(by, y), d, &columns[1][at]);
  hn::Store(hn::Mul(by, z), d, &columns[2][at]);
}

/// Puts pieces [0, packed.count) at `at`, a multiple of kLanes, and up to the next fills the gap.
void UnpackPieces(const NearPieces::Packed& packed, std::size_t at, NearPieces::Pieces& pieces) {
  const Lanes d;
  const Words du;
  const Ints di;
  const auto* words = reinterpret_cast<const std::uint32_t*>(packed.details.data());
  const auto* voxels = reinterpret_cast<const std::int32_t*>(packed.voxels.data());
  const std::size_t end = NearPieces::RoundedUp(packed.count);
  for (std::size_t i = 0; i < end; i += hn::Lanes(d)) {
    hn::Vec<Words> place, normal, tangent;
    hn::LoadInterleaved3(du, words + 3 * i, place, normal, tangent);
    hn::Vec<Ints> vx, vy, vz;
    hn::LoadInterleaved3(di, voxels + 3 * i, vx, vy, vz);
    const auto step = hn::Set(d, 1.0F / 255.0F);
    const auto put = [&](auto voxel, auto byte, std::size_t axis) HWY_ATTR {
      const auto corner = hn::ConvertTo(d, voxel);
      const auto within = hn::ConvertTo(d, hn::BitCast(di, hn::And(byte, hn::Set(du, 255U))));
      hn::Store(hn::Add(corner, hn::Mul(step, within)), d, &pieces.place[axis][at + i]);
      const auto kept = hn::FirstN(d, packed.count - std::min(i, packed.count));
      hn::Store(hn::IfThenElse(kept, corner, hn::Set(d, NearPieces::kFarAway)), d,
                &pieces.voxel[axis][at + i]);
    };
    put(vx, place, 0);
    put(vy, hn::ShiftRight<8>(place), 1);
    put(vz, hn::ShiftRight<16>(place), 2);
    StoreDirection(normal, at + i, pieces.normal);
    StoreDirection(tangent, at + i, pieces.tangent);
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

void Copy(const NearPieces::Columns& from, std::size_t i, std::size_t to,
          NearPieces::Columns& columns) {
  for (std::size_t axis = 0; axis < 3; ++axis) columns[axis][to] = from[axis][i];
}

Vec3f At(const NearPieces::Columns& columns, std::size_t i) {
  return {columns[0][i], columns[1][i], columns[2][i]};
}

void Put(const Vec3f& a, std::size_t i, NearPieces::Columns& columns) {
  columns[0][i] = a.x();
  columns[1][i] = a.y();
  columns[2][i] = a.z();
}

}  // namespace

bool NearPieces::List(const GridIndex& low, const GridIndex& high, Field field) noexcept {
  using Shape = SurfaceDetail::Shape;
  plain_.count = of_ridges_.count = of_corners_.count = 0;
  bool full = false;
  const auto keep = [&](const GridIndex& voxel, const SurfaceDetail& detail, bool /*ends*/) {
    Packed* packed = &plain_;
    if (field == Field::kSurface) {
      const Shape shape = detail.shape();
      if (shape == Shape::kRidge) packed = &of_ridges_;
      if (shape == Shape::kVertex || shape == Shape::kNotch) packed = &of_corners_;
    }
    full = full || packed->count == kMostSources;
    if (full) return;
    packed->details[packed->count] = detail;
    packed->voxels[packed->count++] = voxel - middle_;
  };
  VisitPieces<false>(*voxmap_, *details_, low, high, low, field, keep);
  return !full && plain_.count + of_ridges_.count + of_corners_.count <= kMostSources;
}

void NearPieces::Unpack(const Packed& packed) noexcept {
  HWY_DYNAMIC_DISPATCH(UnpackPieces)(packed, count_, pieces_);
  count_ += RoundedUp(packed.count);
}

void NearPieces::FillGap() noexcept {
  for (; count_ % kLanes != 0; ++count_) pieces_.voxel[0][count_] = kFarAway;
}

void NearPieces::AddOtherSides(const Packed& packed, std::size_t first, Field field) noexcept {
  for (std::size_t i = 0; i < packed.count; ++i) {
    if (packed.details[i].half_length != SurfaceDetail::kTwoSided) continue;
    Copy(pieces_.voxel, first + i, count_, pieces_.voxel);
    Copy(pieces_.place, first + i, count_, pieces_.place);
    Put(-At(pieces_.normal, first + i), count_, pieces_.normal);
    if (field == Field::kEdge) {
      Copy(pieces_.tangent, first + i, count_, pieces_.tangent);
      pieces_.half[count_] = pieces_.half[first + i];
      pieces_.arc_half[count_] = pieces_.arc_half[first + i];
      pieces_.arc_cosine[count_] = pieces_.arc_cosine[first + i];
      pieces_.arc_last[count_] = pieces_.arc_last[first + i];
    }
    ++count_;
  }
  FillGap();
}

void NearPieces::AddOtherFaces(const Packed& packed, std::size_t first) noexcept {
  for (std::size_t i = 0; i < packed.count; ++i) {
    const EdgeArc& arc = ArcOf(packed.details[i]);
    const Vec3f n = At(pieces_.normal, first + i);
    const Vec3f across = static_cast<float>(arc.sine) * At(pieces_.tangent, first + i).cross(n);
    const Vec3f along = static_cast<float>(arc.cosine) * n;
    Put(along + across, first + i, pieces_.normal);
    Copy(pieces_.voxel, first + i, count_, pieces_.voxel);
    Copy(pieces_.place, first + i, count_, pieces_.place);
    Put(along - across, count_++, pieces_.normal);
  }
  FillGap();
}

void NearPieces::SetArcs(const Packed& packed, std::size_t first) noexcept {
  for (std::size_t i = 0; i < packed.count; ++i) {
    const SurfaceDetail& detail = packed.details[i];
    const EdgeArc& arc = ArcOf(detail);
    const bool two_sided = detail.half_length == SurfaceDetail::kTwoSided;
    pieces_.half[first + i] =
        static_cast<float>((two_sided ? 0.5 : detail.half_length / 128.0) + kSeam);
    pieces_.arc_half[first + i] = static_cast<float>(arc.half);
    pieces_.arc_cosine[first + i] = static_cast<float>(arc.cosine);
    pieces_.arc_last[first + i] = static_cast<float>(arc.last);
  }
}

bool NearPieces::Gather(const GridIndex& low, const GridIndex& high, Field field) noexcept {
  middle_ = {(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2};
  count_ = 0;
  if (!List(low - GridIndex{1, 1, 1}, high + GridIndex{1, 1, 1}, field)) return false;
  Unpack(plain_);
  if (field == Field::kEdge) SetArcs(plain_, 0);
  if (field != Field::kVertex) AddOtherSides(plain_, 0, field);
  ridges_ = count_;
  Unpack(of_ridges_);
  AddOtherFaces(of_ridges_, ridges_);
  corners_ = count_;
  Unpack(of_corners_);
  AddOtherSides(of_corners_, corners_, field);
  return true;
}

}  // namespace tandem
#endif
