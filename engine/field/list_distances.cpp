// Distances of places from the faces of their cells' lists, many at a time.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "engine/field/distance_field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/field/list_distances.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TANDEM_LIST_PAIRS
#define TANDEM_LIST_PAIRS
namespace tandem {

/// Places and faces, each with one of the other: what the kernel reads and tells.
struct ListPairs {
  static constexpr std::size_t kMost = 1024;
  std::size_t count = 0;
  /// Where a face's nine numbers begin, its corners one after the other.
  std::array<std::int32_t, kMost> face;
  /// A place as whole voxels and the rest, so that what is large goes before anything is rounded.
  std::array<std::array<float, kMost>, 3> whole;
  std::array<std::array<float, kMost>, 3> rest;
  std::array<float, kMost> squared;  // distance
  std::array<float, kMost> height;   // over the face's plane
};

}  // namespace tandem
#endif

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using Floats = hn::Vec<F>;

struct Lanes3 {
  Floats x, y, z;
};

// never fused: every processor must find the same distance
HWY_INLINE Floats Dot(const Lanes3& a, const Lanes3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Lanes3 Minus(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Lanes3 Cross(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

/// The squared distance of the origin from the edge that begins at `from`.
HWY_INLINE Floats FromEdge(const Lanes3& from, const Lanes3& along) {
  const F f;
  const Floats length = hn::Max(Dot(along, along), hn::Set(f, 1e-30F));
  const Floats t = hn::Div(hn::Neg(Dot(from, along)), length);
  const Floats in = hn::Min(hn::Max(t, hn::Zero(f)), hn::Set(f, 1.0F));
  const Lanes3 closest{hn::Add(from.x, hn::Mul(in, along.x)), hn::Add(from.y, hn::Mul(in, along.y)),
                       hn::Add(from.z, hn::Mul(in, along.z))};
  return Dot(closest, closest);
}

void MeasurePairs(const float* faces, ListPairs& pairs) {
  const F f;
  const I i;
  for (std::size_t k = 0; k < pairs.count; k += hn::Lanes(f)) {
    const auto face = hn::LoadU(i, &pairs.face[k]);
    const auto corner = [&](std::int32_t number) HWY_ATTR {
      const auto along = [&](std::size_t axis) HWY_ATTR {
        const auto at = hn::Add(face, hn::Set(i, 3 * number + static_cast<std::int32_t>(axis)));
        return hn::Sub(hn::Sub(hn::GatherIndex(f, faces, at), hn::LoadU(f, &pairs.whole[axis][k])),
                       hn::LoadU(f, &pairs.rest[axis][k]));
      };
      return Lanes3{along(0), along(1), along(2)};
    };
    const Lanes3 a = corner(0);
    const Lanes3 b = corner(1);
    const Lanes3 c = corner(2);
    const Lanes3 ab = Minus(b, a);
    const Lanes3 bc = Minus(c, b);
    const Lanes3 ca = Minus(a, c);
    const Lanes3 normal = Cross(ab, bc);
    const Floats area = hn::Max(Dot(normal, normal), hn::Set(f, 1e-30F));
    const Floats height = hn::Div(hn::Neg(Dot(a, normal)), hn::Sqrt(area));
    // the origin lies over the face where it is to the left of all edges
    const auto left = [&](const Lanes3& from, const Lanes3& along) HWY_ATTR {
      return hn::Ge(Dot(Cross(from, along), normal), hn::Zero(f));
    };
    auto over = hn::And(left(a, ab), hn::And(left(b, bc), left(c, ca)));
    over = hn::And(over, hn::Gt(Dot(normal, normal), hn::Set(f, 1e-30F)));
    const Floats edges = hn::Min(FromEdge(a, ab), hn::Min(FromEdge(b, bc), FromEdge(c, ca)));
    hn::StoreU(hn::IfThenElse(over, hn::Mul(height, height), edges), f, &pairs.squared[k]);
    hn::StoreU(height, f, &pairs.height[k]);
  }
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

namespace {
HWY_EXPORT(MeasurePairs);
}  // namespace

/// The distances of some places from the faces of their lists.
class ListDistances {
 public:
  ListDistances(const DistanceField& field, double reach, double* distances)
      : field_(field),
        reach_(reach),
        beyond_fine_(reach > field.fine_band()),
        distances_(distances) {}

  /// `number` is where its distance goes.
  void Add(const DistanceField::OpenPlace& place, std::size_t number) {
    const Vec3 place_L = place.place_V - Vec3::Constant(0.5);
    const DistanceField::Cell cell = DistanceField::CellOf(place_L);
    const std::int32_t entry = field_.EntryOf(cell.cell);
    if (entry < 0) {
      distances_[number] = place.value - DistanceField::kMostOver;
      return;
    }
    const FieldBrick& brick = field_.bricks_[static_cast<std::size_t>(entry)];
    const std::optional<DistanceField::List> list = field_.ListOf(brick, cell.cell);
    if (!list) {
      distances_[number] = place.value - brick.Over();
      return;
    }
    double bound = place.value - DistanceField::kListOverStep * list->over;
    if (beyond_fine_) {
      bound = std::min(bound, std::max(field_.fine_band(), place.value - field_.most_over_));
    }
    distances_[number] = bound;
    // of more faces than there is room for, whoever is pushed asks
    if (bound >= reach_ || 8 * list->member_bytes > ListPairs::kMost) return;
    if (pairs_.count + 8 * list->member_bytes > ListPairs::kMost || count_ == kMostQueries) Tell();
    AddFaces(*list, cell, {number, bound, pairs_.count, pairs_.count});
  }

  /// Measures what was added since the last time.
  void Tell() {
    while (pairs_.count % 16 != 0) AddPair(0, {}, {});
    HWY_DYNAMIC_DISPATCH(MeasurePairs)(field_.faces_.data()->data()->data(), pairs_);
    for (std::size_t i = 0; i < count_; ++i) {
      const Query& query = queries_[i];
      const double distance = NearestOf(query);
      // beyond the band other faces may be nearer; and below its border pushes are interpolated too
      const double exact_to = beyond_fine_ ? field_.fine_band() : field_.band_;
      distances_[query.number] = distance > exact_to ? std::max(query.bound, exact_to) : distance;
    }
    count_ = 0;
    pairs_.count = 0;
  }

 private:
  static constexpr std::size_t kMostQueries = 256;
  struct Query {
    std::size_t number;
    double bound;
    std::size_t begin, end;  // of the pairs
  };

  void AddFaces(const DistanceField::List& list, const DistanceField::Cell& cell, Query query) {
    const std::array<float, 3> whole{static_cast<float>(cell.cell.x),
                                     static_cast<float>(cell.cell.y),
                                     static_cast<float>(cell.cell.z)};
    const std::array<float, 3> rest{static_cast<float>(cell.from.x()),
                                    static_cast<float>(cell.from.y()),
                                    static_cast<float>(cell.from.z())};
    for (std::size_t byte = 0; byte < list.member_bytes; ++byte) {
      for (std::uint32_t bits = list.members[byte]; bits != 0; bits &= bits - 1) {
        AddPair(list.faces[8 * byte + static_cast<std::size_t>(std::countr_zero(bits))], whole,
                rest);
      }
    }
    query.end = pairs_.count;
    queries_[count_++] = query;
  }
  void AddPair(std::uint32_t entry, const std::array<float, 3>& whole,
               const std::array<float, 3>& rest) {
    const std::size_t k = pairs_.count++;
    pairs_.face[k] = static_cast<std::int32_t>(9 * (entry & ~DistanceField::kSheet));
    sheet_[k] = (entry & DistanceField::kSheet) != 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      pairs_.whole[axis][k] = whole[axis];
      pairs_.rest[axis][k] = rest[axis];
    }
  }
  /// The nearest face's distance; of equally near ones that one tells the side which turns most to
  /// the place.
  double NearestOf(const Query& query) const {
    float least = std::numeric_limits<float>::max();
    for (std::size_t k = query.begin; k < query.end; ++k) {
      least = std::min(least, pairs_.squared[k]);
    }
    const float distance = std::sqrt(least);
    const float tie = distance + static_cast<float>(DistanceField::kTie);
    float height = 0;
    bool sheet = false;
    for (std::size_t k = query.begin; k < query.end; ++k) {
      if (pairs_.squared[k] > tie * tie || std::abs(pairs_.height[k]) <= std::abs(height)) continue;
      height = pairs_.height[k];
      sheet = sheet_[k];
    }
    return height < 0 && !sheet ? -distance : distance;
  }

  const DistanceField& field_;
  double reach_;
  bool beyond_fine_;
  double* distances_;
  std::array<Query, kMostQueries> queries_;
  std::size_t count_ = 0;
  ListPairs pairs_;
  std::array<bool, ListPairs::kMost> sheet_;
};

void DistanceField::Distances(std::span<const OpenPlace> places, double reach,
                              double* distances) const noexcept {
  ListDistances told(*this, reach, distances);
  for (std::size_t i = 0; i < places.size(); ++i) told.Add(places[i], i);
  told.Tell();
}

}  // namespace tandem
#endif
