#include "engine/field/build/face_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/field/build/face_distance.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

HWY_INLINE Floats Dot(const std::array<float, 3>& a, const Lanes3& b) {
  return Dot(Broadcast(a.data()), b);
}

struct DistanceAndHeight {
  Floats distance, height;
};

HWY_INLINE DistanceAndHeight MeasureVector(const NearFace::View& face, unsigned edges,
                                           const Lanes3& p) {
  const F f;
  const Floats height = hn::Sub(Dot(face.nhat, p), hn::Set(f, face.offset));
  const Floats absolute = hn::Abs(height);
  if (edges == 0) return {absolute, face.sheet ? absolute : height};
  // distance from the face of the place's foot in its plane
  const Floats a = Dot(face.axes[0], p);
  const Floats b = Dot(face.axes[1], p);
  Floats beside = hn::Set(f, std::numeric_limits<float>::max());
  auto over = hn::Eq(beside, beside);
  for (std::size_t k = 0; k < 3; ++k) {
    if ((edges >> k & 1U) == 0) continue;
    const NearFace::View::Edge& edge = face.edges[k];
    const Floats along_a = hn::Set(f, edge.along[0]);
    const Floats along_b = hn::Set(f, edge.along[1]);
    const Floats along = hn::Add(hn::Mul(along_a, a), hn::Mul(along_b, b));
    const Floats inward =
        hn::Sub(hn::Sub(hn::Mul(along_a, b), hn::Mul(along_b, a)), hn::Set(f, edge.inward_offset));
    const Floats past =
        hn::Sub(along, hn::Min(hn::Max(along, hn::Set(f, edge.from)), hn::Set(f, edge.to)));
    over = hn::And(over, hn::Ge(inward, hn::Zero(f)));
    beside = hn::Min(beside, hn::Add(hn::Mul(inward, inward), hn::Mul(past, past)));
  }
  const Floats squared =
      hn::Add(hn::Mul(height, height), hn::IfThenElse(over, hn::Zero(f), beside));
  return {hn::Sqrt(squared), face.sheet ? absolute : height};
}

HWY_INLINE Lanes3 PlacesAt(const PlaceLanes& places, std::size_t i) {
  const F f;
  return {hn::Load(f, &places.x[i]), hn::Load(f, &places.y[i]), hn::Load(f, &places.z[i])};
}

/// Adds a face to the nearest lanes.
HWY_INLINE void AddNearest(const DistanceAndHeight& measured, float* distances, float* heights) {
  const F f;
  const Floats tie = hn::Set(f, NearestLanes::kTie);
  const Floats distance = hn::LoadU(f, distances);
  const Floats height = hn::LoadU(f, heights);
  const auto nearer = hn::Lt(measured.distance, hn::Sub(distance, tie));
  const auto turned = hn::And(hn::Le(measured.distance, hn::Add(distance, tie)),
                              hn::Gt(hn::Abs(measured.height), hn::Abs(height)));
  const auto taken = hn::Or(nearer, turned);
  hn::StoreU(hn::IfThenElse(taken, measured.height, height), f, heights);
  hn::StoreU(hn::Min(distance, measured.distance), f, distances);
}

void MeasureLanes(const NearFace::View& face, const PlaceLanes& places, unsigned edges,
                  float* distances, float* heights) {
  const F f;
  for (std::size_t i = 0; i < places.count; i += hn::Lanes(f)) {
    const DistanceAndHeight measured = MeasureVector(face, edges, PlacesAt(places, i));
    hn::StoreU(measured.distance, f, distances + i);
    if (heights != nullptr) hn::StoreU(measured.height, f, heights + i);
  }
}

void MeasureLanesInto(const NearFace::View& face, const PlaceLanes& places, unsigned edges,
                      NearestLanes& nearest, float* distances) {
  const F f;
  for (std::size_t i = 0; i < places.count; i += hn::Lanes(f)) {
    const DistanceAndHeight measured = MeasureVector(face, edges, PlacesAt(places, i));
    AddNearest(measured, &nearest.distance[i], &nearest.height[i]);
    if (distances != nullptr) hn::StoreU(measured.distance, f, distances + i);
  }
}

/// Calls `visit(i, places)` for the places of a cube.
template <typename Visit>
HWY_INLINE void VisitCube(const std::array<float, 3>& lowest, const Visit& visit) {
  const F f;
  constexpr std::size_t kLayer = kCubeSide * kCubeSide;
  alignas(64) static constexpr std::array<float, kLayer> kX{0, 1, 2, 3, 0, 1, 2, 3,
                                                            0, 1, 2, 3, 0, 1, 2, 3};
  alignas(64) static constexpr std::array<float, kLayer> kY{0, 0, 0, 0, 1, 1, 1, 1,
                                                            2, 2, 2, 2, 3, 3, 3, 3};
  for (std::size_t layer = 0; layer < kCubeSide; ++layer) {
    const Floats z = hn::Set(f, lowest[2] + static_cast<float>(layer));
    for (std::size_t i = 0; i < kLayer; i += hn::Lanes(f)) {
      visit(layer * kLayer + i, Lanes3{hn::Add(hn::Set(f, lowest[0]), hn::Load(f, &kX[i])),
                                       hn::Add(hn::Set(f, lowest[1]), hn::Load(f, &kY[i])), z});
    }
  }
}

void MeasureCubeLanes(const NearFace::View& face, const std::array<float, 3>& lowest,
                      float* distances) {
  const F f;
  VisitCube(lowest, [&](std::size_t i, const Lanes3& places) {
    hn::StoreU(MeasureVector(face, NearFace::kAllEdges, places).distance, f, distances + i);
  });
}

void MeasureCubeLanesInto(const NearFace::View& face, const std::array<float, 3>& lowest,
                          float* distances, float* heights) {
  VisitCube(lowest, [&](std::size_t i, const Lanes3& places) {
    AddNearest(MeasureVector(face, NearFace::kAllEdges, places), distances + i, heights + i);
  });
}

NearFace::CubeSides SidesOfLanes(const NearFace::View& face, const std::array<float, 3>& lowest) {
  const F f;
  NearFace::CubeSides sides;
  for (std::size_t k = 0; k < 3; ++k) {
    const NearFace::View::Edge& edge = face.edges[k];
    float reach = NearFace::kRounding;
    for (std::size_t axis = 0; axis < 3; ++axis) reach += std::abs(edge.inward[axis]) * 0.5F;
    const Floats aside = hn::Set(f, reach);
    VisitCube(lowest, [&](std::size_t i, const Lanes3& p) HWY_ATTR {
      const Floats inward = hn::Sub(Dot(edge.inward, p), hn::Set(f, edge.inward_offset));
      sides.before[k] |= std::uint64_t{MaskBits(F(), hn::Le(inward, aside))} << i;
      sides.beyond[k] |= std::uint64_t{MaskBits(F(), hn::Lt(inward, hn::Neg(aside)))} << i;
    });
  }
  return sides;
}

CellErrors ErrorsOfLanes(const std::array<float, 8>& values, const std::array<float, 3>& lowest,
                         const PlaceLanes& places, const NearestLanes& exact, float band,
                         float most_near) {
  const F f;
  const auto along = [&](const Floats& share, const Floats& from, const Floats& to) HWY_ATTR {
    return hn::Add(from, hn::Mul(share, hn::Sub(to, from)));
  };
  const auto at = [&](std::size_t corner) HWY_ATTR {
    return hn::Set(f, values[corner]);
  };
  Floats within_band = hn::Zero(f);
  Floats beyond = within_band;
  Floats most_over = within_band;
  for (std::size_t i = 0; i < places.count; i += hn::Lanes(f)) {
    const Lanes3 p = PlacesAt(places, i);
    const Floats x = hn::Sub(p.x, hn::Set(f, lowest[0]));
    const Floats y = hn::Sub(p.y, hn::Set(f, lowest[1]));
    const Floats z = hn::Sub(p.z, hn::Set(f, lowest[2]));
    const Floats low = along(y, along(x, at(0), at(1)), along(x, at(2), at(3)));
    const Floats high = along(y, along(x, at(4), at(5)), along(x, at(6), at(7)));
    const Floats value = along(z, low, high);
    const Floats distance = hn::Load(f, &exact.distance[i]);
    const Floats height = hn::Load(f, &exact.height[i]);
    const Floats reported =
        hn::IfThenElse(hn::Lt(height, hn::Zero(f)), hn::Neg(distance), distance);
    const Floats error = hn::Abs(hn::Sub(value, reported));
    // a value beyond `most_near` is read as that
    most_over = hn::Max(most_over, hn::Sub(hn::Min(value, hn::Set(f, most_near)), reported));
    const Floats least = hn::Min(hn::Abs(value), distance);
    const auto in_band = hn::Lt(least, hn::Set(f, band));
    within_band = hn::Max(within_band, hn::IfThenElseZero(in_band, error));
    const auto is_near = hn::Le(least, hn::Set(f, most_near));
    beyond = hn::Max(beyond, hn::IfThenElseZero(hn::AndNot(in_band, is_near), error));
  }
  const auto most = [&](const Floats& v) HWY_ATTR {
    return hn::GetLane(hn::MaxOfLanes(f, v));
  };
  return {most(within_band), most(beyond), most(most_over)};
}

std::uint64_t CompareLanes(const float* values, const float* bounds, float margin,
                           std::size_t count) {
  const F f;
  const Floats more = hn::Set(f, margin);
  std::uint64_t within = 0;
  for (std::size_t i = 0; i < count; i += hn::Lanes(f)) {
    const auto mask = hn::Le(hn::LoadU(f, values + i), hn::Add(hn::LoadU(f, bounds + i), more));
    within |= std::uint64_t{MaskBits(f, mask)} << i;
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
HWY_EXPORT(MeasureCubeLanes);
HWY_EXPORT(MeasureCubeLanesInto);
HWY_EXPORT(ErrorsOfLanes);
HWY_EXPORT(SidesOfLanes);

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

std::uint64_t LanesWithin(const float* values, const float* bounds, float margin,
                          std::size_t count) {
  return HWY_DYNAMIC_DISPATCH(CompareLanes)(values, bounds, margin, count);
}

NearFace::NearFace(const FieldFace& face, const Vec3& origin_L) {
  view_.nhat = Single(face.nhat);
  view_.offset = static_cast<float>(face.nhat.dot(face.corners_L[0] - origin_L));
  view_.sheet = face.sheet;
  Eigen::Index least = 0;
  face.nhat.cwiseAbs().minCoeff(&least);
  const Vec3 first = face.nhat.cross(Vec3::Unit(least)).normalized();
  const Vec3 second = face.nhat.cross(first);
  view_.axes = {Single(first), Single(second)};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 from = face.corners_L[k] - origin_L;
    const Vec3 side = face.corners_L[(k + 1) % 3] - face.corners_L[k];
    const double length = side.norm();
    View::Edge& edge = view_.edges[k];
    const Vec3 along = length > 0 ? Vec3(side / length) : Vec3(Vec3::Zero());
    // farther than any place that is measured
    constexpr double kFar = 128;
    edge.along = {static_cast<float>(along.dot(first)), static_cast<float>(along.dot(second))};
    edge.from = static_cast<float>(std::clamp(along.dot(from), -kFar, kFar));
    edge.to = static_cast<float>(std::clamp(along.dot(from) + length, -kFar, kFar));
    const Vec3 inward = face.nhat.cross(along);
    edge.inward = Single(inward);
    // nothing lies over a face without area
    edge.inward_offset =
        length > 0 ? static_cast<float>(inward.dot(from)) : std::numeric_limits<float>::max();
  }
}

void NearFace::Measure(const PlaceLanes& places, unsigned edges, float* distances,
                       float* heights) const {
  HWY_DYNAMIC_DISPATCH(MeasureLanes)(view_, places, edges, distances, heights);
}

void NearFace::MeasureInto(const PlaceLanes& places, unsigned edges, NearestLanes& nearest,
                           float* distances) const {
  HWY_DYNAMIC_DISPATCH(MeasureLanesInto)(view_, places, edges, nearest, distances);
}

void NearFace::MeasureCube(const std::array<float, 3>& lowest, float* distances) const {
  HWY_DYNAMIC_DISPATCH(MeasureCubeLanes)(view_, lowest, distances);
}

void NearFace::MeasureCubeInto(const std::array<float, 3>& lowest, float* distances,
                               float* heights) const {
  HWY_DYNAMIC_DISPATCH(MeasureCubeLanesInto)(view_, lowest, distances, heights);
}

NearFace::CubeSides NearFace::SidesOf(const std::array<float, 3>& lowest) const {
  return HWY_DYNAMIC_DISPATCH(SidesOfLanes)(view_, lowest);
}

CellErrors ErrorsInCell(const std::array<float, 8>& values, const std::array<float, 3>& lowest,
                        const PlaceLanes& places, const NearestLanes& exact, float band,
                        float most_near) {
  return HWY_DYNAMIC_DISPATCH(ErrorsOfLanes)(values, lowest, places, exact, band, most_near);
}

NearestLanes::NearestLanes(std::size_t count) {
  std::fill_n(distance.begin(), count, std::numeric_limits<float>::max());
  std::fill_n(height.begin(), count, 0.0F);
}

}  // namespace tandem
#endif
