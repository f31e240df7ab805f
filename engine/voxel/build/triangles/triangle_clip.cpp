#include "engine/voxel/build/triangles/triangle_clip.h"

#include <algorithm>
#include <cstddef>

namespace tandem {

namespace {

/// A polygon. A triangle cut to a box has at most nine corners.
struct Polygon {
  std::array<Vec3, 10> corners;
  std::size_t count = 0;
};

/// Cuts away the part beyond `limit` along an axis; `side` +1 keeps the lower part, -1 the upper.
/// `spare` is scratch.
void Clip(Polygon& polygon, Polygon& spare, int axis, double limit, double side) {
  std::array<double, 10> within;  // per corner
  double least = 0;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    within[i] = side * (limit - polygon.corners[i][axis]);
    least = std::min(least, within[i]);
  }
  if (least >= 0) return;
  spare.count = 0;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const std::size_t next = i + 1 < polygon.count ? i + 1 : 0;
    const double da = within[i];
    const double db = within[next];
    if (da >= 0) spare.corners[spare.count++] = polygon.corners[i];
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      const Vec3& a = polygon.corners[i];
      spare.corners[spare.count++] = a + da / (da - db) * (polygon.corners[next] - a);
    }
  }
  polygon.count = spare.count;
  std::copy_n(spare.corners.begin(), spare.count, polygon.corners.begin());
}

}  // namespace

TrianglePart PartInCell(const std::array<Vec3, 3>& triangle, const Vec3& cell) {
  Polygon polygon;
  Polygon spare;
  polygon.count = 3;
  std::copy(triangle.begin(), triangle.end(), polygon.corners.begin());
  for (int axis = 0; axis < 3; ++axis) {
    Clip(polygon, spare, axis, cell[axis], -1.0);
    Clip(polygon, spare, axis, cell[axis] + 1.0, 1.0);
  }
  TrianglePart part;
  for (std::size_t i = 2; i < polygon.count; ++i) {
    const Vec3 area = (polygon.corners[i - 1] - polygon.corners[0])
                          .cross(polygon.corners[i] - polygon.corners[0]);
    part.area += area;
    part.moment +=
        area.norm() / 3.0 * (polygon.corners[0] + polygon.corners[i - 1] + polygon.corners[i]);
  }
  return part;
}

}  // namespace tandem
