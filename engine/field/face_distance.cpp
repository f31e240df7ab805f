#include "engine/field/face_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/field/face_distance.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using Floats = hn::Vec<F>;

struct VectorLanes {
  Floats x, y, z;
};

// never fused: every processor must find the same distance
HWY_INLINE Floats Dot(const std::array<float, 3>& a, const VectorLanes& b) {
  const F f;
  const Floats xy = hn::Add(hn::Mul(hn::Set(f, a[0]), b.x), hn::Mul(hn::Set(f, a[1]), b.y));
  return hn::Add(xy, hn::Mul(hn::Set(f, a[2]), b.z));
}

/// The squared distance from an edge.
HWY_INLINE Floats FromEdge(const NearFace::View::Edge& edge, const VectorLanes& p) {
  const F f;
  const VectorLanes q{hn::Sub(p.x, hn::Set(f, edge.start[0])),
                      hn::Sub(p.y, hn::Set(f, edge.start[1])),
                      hn::Sub(p.z, hn::Set(f, edge.start[2]))};
  const Floats t = hn::Min(hn::Max(Dot(edge.along, q), hn::Set(f, edge.from)), hn::Set(f, edge.to));
  const Floats x = hn::Sub(q.x, hn::Mul(t, hn::Set(f, edge.along[0])));
  const Floats y = hn::Sub(q.y, hn::Mul(t, hn::Set(f, edge.along[1])));
  const Floats z = hn::Sub(q.z, hn::Mul(t, hn::Set(f, edge.along[2])));
  return hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
}

struct DistanceAndHeight {
  Floats distance, height;
};

HWY_INLINE DistanceAndHeight MeasureVector(const NearFace::View& face, const PlaceLanes& places,
                                           std::size_t i) {
  const F f;
  const VectorLanes p{hn::Load(f, &places.x[i]), hn::Load(f, &places.y[i]),
                      hn::Load(f, &places.z[i])};
  const Floats height = hn::Sub(Dot(face.nhat, p), hn::Set(f, face.offset));
  Floats squared = hn::Set(f, std::numeric_limits<float>::max());
  auto over = hn::Eq(squared, squared);
  for (const NearFace::View::Edge& edge : face.edges) {
    over = hn::And(over, hn::Ge(Dot(edge.inward, p), hn::Set(f, edge.inward_offset)));
    squared = hn::Min(squared, FromEdge(edge, p));
  }
  squared = hn::IfThenElse(over, hn::Mul(height, height), squared);
  return {hn::Sqrt(squared), face.sheet ? hn::Abs(height) : height};
}

void MeasureLanes(const NearFace::View& face, const PlaceLanes& places, float* distances,
                  float* heights) {
  const F f;
  for (std::size_t i = 0; i < places.count; i += hn::Lanes(f)) {
    const DistanceAndHeight told = MeasureVector(face, places, i);
    hn::StoreU(told.distance, f, distances + i);
    if (heights != nullptr) hn::StoreU(told.height, f, heights + i);
  }
}

bool MeasureLanesInto(const NearFace::View& face, const PlaceLanes& places, NearestLanes& nearest) {
  const F f;
  const Floats tie = hn::Set(f, NearestLanes::kTie);
  bool any = false;
  for (std::size_t i = 0; i < places.count; i += hn::Lanes(f)) {
    const DistanceAndHeight told = MeasureVector(face, places, i);
    const Floats distance = hn::Load(f, &nearest.distance[i]);
    const Floats height = hn::Load(f, &nearest.height[i]);
    const auto nearer = hn::Lt(told.distance, hn::Sub(distance, tie));
    const auto turned = hn::And(hn::Le(told.distance, hn::Add(distance, tie)),
                                hn::Gt(hn::Abs(told.height), hn::Abs(height)));
    const auto taken = hn::Or(nearer, turned);
    any = any || !hn::AllFalse(f, taken);
    hn::Store(hn::IfThenElse(taken, told.height, height), f, &nearest.height[i]);
    hn::Store(hn::Min(distance, told.distance), f, &nearest.distance[i]);
  }
  return any;
}

std::uint64_t CompareLanes(const float* values, const float* bounds, float margin) {
  const F f;
  const Floats more = hn::Set(f, margin);
  std::uint64_t within = 0;
  for (std::size_t i = 0; i < 64; i += hn::Lanes(f)) {
    const auto mask = hn::Le(hn::LoadU(f, values + i), hn::Add(hn::LoadU(f, bounds + i), more));
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(f, mask, bits.data());
    for (std::size_t byte = 0; 8 * byte < hn::Lanes(f); ++byte) {
      within |= std::uint64_t{bits[byte]} << (i + 8 * byte);
    }
  }
  return within;
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

namespace {

HWY_EXPORT(MeasureLanes);
HWY_EXPORT(MeasureLanesInto);
HWY_EXPORT(CompareLanes);

std::array<float, 3> Single(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

PlaceLanes LatticeLanes(std::size_t side, double first, double spacing) {
  PlaceLanes lanes;
  const std::size_t nodes = side * side * side;
  lanes.count = (nodes + 15) / 16 * 16;
  for (std::size_t i = 0; i < lanes.count; ++i) {
    const std::size_t node = std::min(i, nodes - 1);
    const auto at = [&](std::size_t step) {
      return static_cast<float>(first + spacing * static_cast<double>(step));
    };
    lanes.x[i] = at(node % side);
    lanes.y[i] = at(node / side % side);
    lanes.z[i] = at(node / side / side);
  }
  return lanes;
}

std::uint64_t LanesWithin(const float* values, const float* bounds, float margin) {
  return HWY_DYNAMIC_DISPATCH(CompareLanes)(values, bounds, margin);
}

NearFace::NearFace(const FieldFace& face, const Vec3& origin_L) {
  view_.nhat = Single(face.nhat);
  view_.offset = static_cast<float>(face.nhat.dot(face.corners_L[0] - origin_L));
  view_.sheet = face.sheet;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 from = face.corners_L[k] - origin_L;
    const Vec3 side = face.corners_L[(k + 1) % 3] - face.corners_L[k];
    const double length = side.norm();
    View::Edge& edge = view_.edges[k];
    const Vec3 along = length > 0 ? Vec3(side / length) : Vec3(Vec3::Zero());
    const double passed = -along.dot(from);
    // beyond this an end is farther than any place asks for
    constexpr double kFar = 32;
    edge.along = Single(along);
    edge.start = Single(from + passed * along);
    edge.from = static_cast<float>(std::clamp(-passed, -kFar, kFar));
    edge.to = static_cast<float>(std::clamp(length - passed, -kFar, kFar));
    const Vec3 inward = face.nhat.cross(along);
    edge.inward = Single(inward);
    // nothing lies over a face without area
    edge.inward_offset =
        length > 0 ? static_cast<float>(inward.dot(from)) : std::numeric_limits<float>::max();
  }
}

void NearFace::Measure(const PlaceLanes& places, float* distances, float* heights) const {
  HWY_DYNAMIC_DISPATCH(MeasureLanes)(view_, places, distances, heights);
}

bool NearFace::MeasureInto(const PlaceLanes& places, NearestLanes& nearest) const {
  return HWY_DYNAMIC_DISPATCH(MeasureLanesInto)(view_, places, nearest);
}

NearestLanes::NearestLanes() {
  distance.fill(std::numeric_limits<float>::max());
  height.fill(0);
}

}  // namespace tandem
#endif
