#include "engine/geometry/formats/polygon_split.h"

#include <array>
#include <cmath>

#include "engine/base/spatial.h"

namespace tandem {

namespace {

struct FlatPoint {
  double x = 0;
  double y = 0;
};

double Turn(const FlatPoint& a, const FlatPoint& b, const FlatPoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

Vec3 Place(const FloatPoint& p) {
  return {double{p[0]}, double{p[1]}, double{p[2]}};
}

/// Returns the corners as seen against the polygon's mean normal, counter-clockwise.
std::vector<FlatPoint> Flattened(std::span<const FloatPoint> points,
                                 std::span<const std::uint32_t> corners) {
  Vec3 normal = Vec3::Zero();  // by Newell's method
  const Vec3 origin = Place(points[corners[0]]);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = Place(points[corners[i]]) - origin;
    const Vec3 b = Place(points[corners[(i + 1) % corners.size()]]) - origin;
    normal += a.cross(b);
  }
  int largest = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(normal[i]) > std::abs(normal[largest])) largest = i;
  }
  const double sign = normal[largest] < 0 ? -1 : 1;
  std::vector<FlatPoint> flat;
  for (const std::uint32_t corner : corners) {
    const Vec3 p = Place(points[corner]) - origin;
    flat.push_back({sign * p[(largest + 1) % 3], p[(largest + 2) % 3]});
  }
  return flat;
}

bool IsEar(const std::vector<FlatPoint>& flat, const std::vector<std::uint32_t>& left,
           std::size_t at) {
  const std::size_t n = left.size();
  const std::array<std::uint32_t, 3> ear{left[(at + n - 1) % n], left[at], left[(at + 1) % n]};
  if (!(Turn(flat[ear[0]], flat[ear[1]], flat[ear[2]]) > 0)) return false;
  for (const std::uint32_t other : left) {
    if (other == ear[0] || other == ear[1] || other == ear[2]) continue;
    const FlatPoint& p = flat[other];
    const bool at_corner = (p.x == flat[ear[0]].x && p.y == flat[ear[0]].y) ||
                           (p.x == flat[ear[2]].x && p.y == flat[ear[2]].y);
    if (at_corner) continue;  // two corners in one place, as where a hole was cut open
    if (Turn(flat[ear[0]], flat[ear[1]], p) >= 0 && Turn(flat[ear[1]], flat[ear[2]], p) >= 0 &&
        Turn(flat[ear[2]], flat[ear[0]], p) >= 0) {
      return false;
    }
  }
  return true;
}

bool IsConvex(const std::vector<FlatPoint>& flat) {
  const std::size_t n = flat.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (Turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) < 0) return false;
  }
  return true;
}

}  // namespace

void SplitPolygon(std::span<const FloatPoint> points, std::span<const std::uint32_t> corners,
                  std::vector<TriangleMesh::Triangle>& triangles) {
  if (corners.size() < 3) return;
  const std::vector<FlatPoint> flat = Flattened(points, corners);
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles.push_back({corners[a], corners[b], corners[c]});
  };
  // a polygon that winds round twice is convex at each corner too, and is cut in some way in either
  // case
  if (corners.size() == 3 || IsConvex(flat)) {
    for (std::uint32_t i = 2; i < corners.size(); ++i) add(0, i - 1, i);
    return;
  }
  std::vector<std::uint32_t> left;
  for (std::uint32_t i = 0; i < corners.size(); ++i) left.push_back(i);
  std::size_t at = 0;
  std::size_t refused = 0;
  while (left.size() > 3) {
    // where no corner is an ear, the polygon crosses itself or is flat: then any corner will do
    const bool is_ear = IsEar(flat, left, at) || refused >= left.size();
    const std::size_t n = left.size();
    if (is_ear) {
      add(left[(at + n - 1) % n], left[at], left[(at + 1) % n]);
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
      refused = 0;
      if (at == left.size()) at = 0;
    } else {
      ++refused;
      at = (at + 1) % n;
    }
  }
  add(left[0], left[1], left[2]);
}

}  // namespace tandem
