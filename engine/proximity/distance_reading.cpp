#include <algorithm>
#include <cmath>

#include "engine/proximity/proximity.h"

namespace tandem {

namespace {

/// Returns the chess-board distance of a voxel from the surface, voxels; 0 on it and inside.
float DistanceOf(int mark) {
  return static_cast<float>(std::max(0, mark - kSurfaceMark));
}

/// A voxel, and the share of the way along each axis from its centre to the next voxel's centre.
struct Lerp {
  GridIndex voxel;
  std::array<float, 3> share;
};

Lerp Locate(float x, float y, float z) {
  const float fx = std::floor(x);
  const float fy = std::floor(y);
  const float fz = std::floor(z);
  return {
      {static_cast<std::int32_t>(fx), static_cast<std::int32_t>(fy), static_cast<std::int32_t>(fz)},
      {x - fx, y - fy, z - fz}};
}

float Mix(float a, float b, float share) {
  return a + share * (b - a);
}

/// Returns the distances at the eight corners round `voxel`, whose chunk lies within the box.
std::array<float, 8> CornersOf(const Voxmap& map, const GridIndex& voxel) {
  std::array<float, 8> d;
  const bool in_one_chunk = (voxel.x & 7) != 7 && (voxel.y & 7) != 7 && (voxel.z & 7) != 7;
  if (!in_one_chunk) {
    for (std::int32_t k = 0; k < 8; ++k) {
      const GridIndex corner = voxel + GridIndex{k & 1, k >> 1 & 1, k >> 2};
      d[static_cast<std::size_t>(k)] = DistanceOf(map.Value(Field::kSurface, corner));
    }
    return d;
  }
  const std::uint32_t plane = map.PlaneOf(Field::kSurface, voxel >> 3);
  const std::size_t cell = CellInBlock(voxel);
  for (std::size_t k = 0; k < 8; ++k) {
    const int stored = map.StoredMark(plane, cell + (k & 1) + 8 * (k >> 1 & 1) + 64 * (k >> 2));
    d[k] = DistanceOf(stored != 0 ? stored : map.beyond());
  }
  return d;
}

float Interpolated(const Voxmap& map, const Lerp& at) {
  const std::array<float, 8> d = CornersOf(map, at.voxel);
  const float x = at.share[0];
  const float low = Mix(Mix(d[0], d[1], x), Mix(d[2], d[3], x), at.share[1]);
  const float high = Mix(Mix(d[4], d[5], x), Mix(d[6], d[7], x), at.share[1]);
  return Mix(low, high, at.share[2]);
}

Vec3 InVoxels(const Voxmap& map, const Vec3& p_B) {
  return p_B / map.voxel_size() - Vec3(map.origin().x, map.origin().y, map.origin().z);
}

bool IsInterior(const Voxmap& map, const Vec3& p_B) {
  const Vec3 p = InVoxels(map, p_B);
  const auto down = [](double x) {
    return static_cast<std::int32_t>(std::floor(x));
  };
  return map.Value(Field::kSurface, {down(p.x()), down(p.y()), down(p.z())}) == kInteriorMark;
}

/// Returns the distance within which some surface voxel lies if the field is in range, m.
double ReachOf(const Voxmap& map) {
  return std::sqrt(3.0) * (map.range() + 1) * map.voxel_size();
}

constexpr double kTooNear = 1.5;      // voxels; nearer, the centres of voxels lie in all directions
constexpr double kSpreadReach = 2.0;  // voxels beyond the nearest, with a weight of 1/e a voxel

/// Returns the outward direction by the side of the surface that the voxels round p are on, where
/// the nearest voxels are too near to tell. Zero on a thin sheet, which has no inside.
Vec3 OutwardBySides(const Voxmap& map, const Vec3& p_in_voxels) {
  constexpr std::int32_t kReach = 3;
  const Eigen::Vector3f p = p_in_voxels.cast<float>();
  const Lerp at = Locate(p.x(), p.y(), p.z());
  Vec3 sum = Vec3::Zero();
  for (std::int32_t z = -kReach; z <= kReach; ++z) {
    for (std::int32_t y = -kReach; y <= kReach; ++y) {
      for (std::int32_t x = -kReach; x <= kReach; ++x) {
        const int mark = map.Value(Field::kSurface, at.voxel + GridIndex{x, y, z});
        if (mark == kSurfaceMark) continue;  // on neither side
        const Vec3 offset(x + 0.5 - at.share[0], y + 0.5 - at.share[1], z + 0.5 - at.share[2]);
        const double weight = std::max(0.0, 1 - offset.squaredNorm() / (kReach * kReach));
        sum += (mark == kInteriorMark ? -weight : weight) * offset;
      }
    }
  }
  return sum;
}

}  // namespace

void LowerDistances(std::span<const std::array<float, 3>> points_A, const Pose& X_BA,
                    const Voxmap& map_B, std::span<float> distances) noexcept {
  if (map_B.empty()) return;
  const double per_m = 1.0 / map_B.voxel_size();
  const Eigen::Matrix3f R = (per_m * X_BA.q.toRotationMatrix()).cast<float>();
  const Vec3 origin(map_B.origin().x, map_B.origin().y, map_B.origin().z);
  // relative to the centre of V's first voxel
  const Eigen::Vector3f t = (per_m * X_BA.p - origin - Vec3::Constant(0.5)).cast<float>();
  const auto voxel_size = static_cast<float>(map_B.voxel_size());
  const auto beyond = DistanceOf(map_B.beyond());
  const std::size_t count = std::min(points_A.size(), distances.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<float, 3>& p = points_A[i];
    const Lerp at = Locate(R(0, 0) * p[0] + R(0, 1) * p[1] + R(0, 2) * p[2] + t.x(),
                           R(1, 0) * p[0] + R(1, 1) * p[1] + R(1, 2) * p[2] + t.y(),
                           R(2, 0) * p[0] + R(2, 1) * p[1] + R(2, 2) * p[2] + t.z());
    // no mark in the voxel's chunk nor in those that touch it
    if (map_B.ChunkValue(at.voxel >> 3) > kSurfaceMark + 1) continue;
    const float d = Interpolated(map_B, at);
    if (d < beyond) distances[i] = std::min(distances[i], voxel_size * d);
  }
}

std::array<float, 3> ProximityColour(double distance, double range) noexcept {
  constexpr std::array<std::array<float, 3>, 5> kStops{{{0.84F, 0.10F, 0.11F},
                                                        {0.96F, 0.43F, 0.26F},
                                                        {1.00F, 0.88F, 0.56F},
                                                        {0.67F, 0.85F, 0.91F},
                                                        {0.27F, 0.46F, 0.71F}}};
  if (!(distance < range)) return kStops.back();
  const auto at = static_cast<float>(std::max(0.0, distance / range * 4));
  const auto stop = std::min<std::size_t>(static_cast<std::size_t>(at), 3);
  std::array<float, 3> colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    colour[k] = Mix(kStops[stop][k], kStops[stop + 1][k], at - static_cast<float>(stop));
  }
  return colour;
}

Vec3 VoxelGradient(const ProximityShape& shape, const Vec3& p_B) noexcept {
  const Voxmap& map = shape.voxmap;
  if (map.empty()) return Vec3::Zero();
  const double s = map.voxel_size();
  const std::optional<Vec3> nearest = shape.surface.Nearest(p_B, ReachOf(map));
  if (!nearest) return Vec3::Zero();
  const double distance = (p_B - *nearest).norm();
  if (distance < kTooNear * s) {
    const Vec3 outward = OutwardBySides(map, InVoxels(map, p_B));
    if (!outward.isZero()) return outward.normalized();
  }
  // the mean of all voxels that are nearly the nearest: a single voxel would point to its own
  // centre, half a voxel aside
  Vec3 sum = Vec3::Zero();
  shape.surface.VisitWithin(p_B, distance + kSpreadReach * s, [&](const Vec3& centre) {
    const Vec3 away = p_B - centre;
    const double d = away.norm();
    if (d > 0) sum += (std::exp(-(d - distance) / s) / d) * away;
  });
  if (sum.norm() < 1e-9) return Vec3::Zero();
  return (IsInterior(map, p_B) ? -1.0 : 1.0) * sum.normalized();
}

}  // namespace tandem
