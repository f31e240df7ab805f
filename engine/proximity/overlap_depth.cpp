#include <algorithm>
#include <cmath>

#include "engine/proximity/closest_place.h"
#include "engine/proximity/proximity.h"

namespace tandem {

namespace {

/// The most places of each surface that are tried.
constexpr std::size_t kMostPlaces = 4000;

/// Calls visit(place in B) for places of A's surface in voxels of B's surface and inside.
template <class Visit>
void VisitPlaces(const ProximityShape& a, const ProximityShape& b, const RotatedFrame& X_BA,
                 const Visit& visit) noexcept {
  const Voxmap& map = b.voxmap;
  const double per_m = 1.0 / map.voxel_size();
  const Vec3 origin(map.origin().x, map.origin().y, map.origin().z);
  const auto may_lie_inside = [&](const Vec3& p_B) {
    const Vec3 p = p_B * per_m - origin;
    const GridIndex voxel{static_cast<std::int32_t>(std::floor(p.x())),
                          static_cast<std::int32_t>(std::floor(p.y())),
                          static_cast<std::int32_t>(std::floor(p.z()))};
    return map.Value(Field::kSurface, voxel) <= kSurfaceMark;
  };
  for (const auto& corners : a.mesh.triangles) {
    for (const Vec3& corner : corners) {
      const Vec3 p_B = X_BA.R * corner + X_BA.p;
      if (may_lie_inside(p_B)) visit(p_B);
    }
  }
  for (const SurfaceTree::Chunk& chunk : a.surface.chunks()) {
    VisitCells(chunk.bits, [&](std::size_t cell) {
      const Vec3 centre = a.surface.CentreOf(chunk.first + BlockCell(cell));
      if (!may_lie_inside(X_BA.R * centre + X_BA.p)) return;
      visit(X_BA.R * ClosestTo(a.mesh, centre) + X_BA.p);
    });
  }
}

/// Returns the depth of the deepest place tried of A's surface in B.
double DepthIn(const ProximityShape& a, const ProximityShape& b, const Pose& X_BA) noexcept {
  if (a.surface.empty() || b.voxmap.empty()) return 0;
  const RotatedFrame turned(X_BA);
  std::size_t places = 0;
  VisitPlaces(a, b, turned, [&](const Vec3&) {
    ++places;
  });
  const std::size_t stride = 1 + places / kMostPlaces;
  std::size_t number = 0;
  double deepest = 0;
  VisitPlaces(a, b, turned, [&](const Vec3& p_B) {
    if (number++ % stride != 0) return;
    const double depth = (p_B - ClosestTo(b.mesh, p_B)).norm();
    if (depth > deepest && b.winding->At(p_B) >= 0.5) deepest = depth;
  });
  return deepest;
}

}  // namespace

double DepthOfOverlap(const ProximityShape& a, const ProximityShape& b, const Pose& X_BA) noexcept {
  return std::max(DepthIn(a, b, X_BA), DepthIn(b, a, X_BA.Inverse()));
}

}  // namespace tandem
