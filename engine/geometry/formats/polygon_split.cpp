#include "engine/geometry/formats/polygon_split.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

Vec3 Place(const FilePoint& p) {
  return {p[0], p[1], p[2]};
}

/// A plane on which a polygon is seen against its mean normal: counter-clockwise.
class Projection {
 public:
  Projection(std::span<const FilePoint> points, std::span<const std::uint32_t> corners)
      : points_(points), origin_(Place(points[corners[0]])) {
    Vec3 normal = Vec3::Zero();  // by Newell's method
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3 a = Place(points[corners[i]]) - origin_;
      const Vec3 b = Place(points[corners[(i + 1) % corners.size()]]) - origin_;
      normal += a.cross(b);
    }
    for (int i = 1; i < 3; ++i) {
      if (std::abs(normal[i]) > std::abs(normal[largest_])) largest_ = i;
    }
    sign_ = normal[largest_] < 0 ? -1 : 1;
  }

  std::vector<FlatPoint> Flattened(std::span<const std::uint32_t> corners) const {
    std::vector<FlatPoint> flat;
    for (const std::uint32_t corner : corners) {
      const Vec3 p = Place(points_[corner]) - origin_;
      flat.push_back({sign_ * p[(largest_ + 1) % 3], p[(largest_ + 2) % 3]});
    }
    return flat;
  }

 private:
  std::span<const FilePoint> points_;
  Vec3 origin_;
  int largest_ = 0;
  double sign_ = 1;
};

bool Same(const FlatPoint& a, const FlatPoint& b) {
  return a.x == b.x && a.y == b.y;
}

bool IsEar(const std::vector<FlatPoint>& flat, const std::vector<std::uint32_t>& left,
           std::size_t at) {
  const std::size_t n = left.size();
  const FlatPoint& before = flat[left[(at + n - 1) % n]];
  const FlatPoint& tip = flat[left[at]];
  const FlatPoint& behind = flat[left[(at + 1) % n]];
  if (!(Turn(before, tip, behind) > 0)) return false;
  for (std::size_t i = 0; i < n; ++i) {
    if (i == at || i == (at + 1) % n || i == (at + n - 1) % n) continue;
    const FlatPoint& p = flat[left[i]];
    // two corners in one place, as where a hole was cut open
    if (Same(p, before) || Same(p, behind)) continue;
    if (Same(p, tip)) {
      for (const std::size_t next : {(i + 1) % n, (i + n - 1) % n}) {
        const FlatPoint& q = flat[left[next]];
        if (Turn(before, tip, q) > 0 && Turn(tip, behind, q) > 0) return false;
      }
      continue;
    }
    if (Turn(before, tip, p) >= 0 && Turn(tip, behind, p) >= 0 && Turn(behind, before, p) >= 0) {
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

double SignedArea(const std::vector<FlatPoint>& flat) {
  double twice = 0;
  for (std::size_t i = 0; i < flat.size(); ++i)
    twice += Turn(flat[0], flat[i], flat[(i + 1) % flat.size()]);
  return twice / 2;
}

/// Tells whether a point lies within a polygon.
bool Contains(const std::vector<FlatPoint>& flat, const FlatPoint& p) {
  bool inside = false;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const FlatPoint& a = flat[i];
    const FlatPoint& b = flat[(i + 1) % flat.size()];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if (p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

/// Returns the corner of a polygon that a hole's rightmost corner sees: along +x it meets an edge,
/// and no corner that points inwards stands between (Eberly, "Triangulation by ear clipping").
std::size_t SeenFrom(const std::vector<FlatPoint>& flat, const FlatPoint& m) {
  std::size_t seen = flat.size();
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const FlatPoint& a = flat[i];
    const FlatPoint& b = flat[(i + 1) % flat.size()];
    if ((a.y > m.y) == (b.y > m.y)) continue;
    const double x = a.x + (m.y - a.y) / (b.y - a.y) * (b.x - a.x);
    if (x < m.x || x >= nearest) continue;
    nearest = x;
    seen = a.x > b.x ? i : (i + 1) % flat.size();
  }
  if (seen == flat.size()) return seen;
  const FlatPoint met{nearest, m.y};
  const FlatPoint end = flat[seen];
  const double side = Turn(m, met, end) >= 0 ? 1 : -1;
  double flattest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const FlatPoint& p = flat[i];
    const std::size_t n = flat.size();
    const bool inwards = Turn(flat[(i + n - 1) % n], p, flat[(i + 1) % n]) <= 0;
    const bool between = side * Turn(m, met, p) >= 0 && side * Turn(met, end, p) >= 0 &&
                         side * Turn(end, m, p) >= 0 && p.x > m.x;
    if (!inwards || !between || i == seen) continue;
    const double slope = std::abs(p.y - m.y) / (p.x - m.x);
    const double own = std::abs(end.y - m.y) / (end.x - m.x);
    if (slope > own || slope >= flattest) continue;
    flattest = slope;
    seen = i;
  }
  return seen;
}

/// Cuts ears off until a triangle is left.
void CutEars(const std::vector<FlatPoint>& flat, std::span<const std::uint32_t> corners,
             std::vector<TriangleMesh::Triangle>& triangles) {
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles.push_back({corners[a], corners[b], corners[c]});
  };
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

/// Returns one round of corners that go round several times.
std::span<const std::uint32_t> OneRound(std::span<const std::uint32_t> corners) {
  for (std::size_t round = 3; 2 * round <= corners.size(); ++round) {
    if (corners[round] != corners[0] || corners.size() % round != 0) continue;
    if (std::equal(corners.begin() + static_cast<std::ptrdiff_t>(round), corners.end(),
                   corners.begin())) {
      return corners.first(round);
    }
  }
  return corners;
}

}  // namespace

void SplitPolygon(std::span<const FilePoint> points, std::span<const std::uint32_t> corners,
                  std::vector<TriangleMesh::Triangle>& triangles) {
  if (corners.size() < 3) return;
  corners = OneRound(corners);
  const std::vector<FlatPoint> flat = Projection(points, corners).Flattened(corners);
  // a polygon that winds round twice is convex at each corner too, and is cut in some way in either
  // case
  if (corners.size() == 3 || IsConvex(flat)) {
    for (std::uint32_t i = 2; i < corners.size(); ++i) {
      triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
    return;
  }
  CutEars(flat, corners, triangles);
}

bool SplitPolygonWithHoles(std::span<const FilePoint> points, std::vector<std::uint32_t> corners,
                           std::vector<std::vector<std::uint32_t>> holes,
                           std::vector<TriangleMesh::Triangle>& triangles) {
  if (corners.size() < 3) return false;
  const Projection projection(points, corners);
  std::vector<FlatPoint> flat = projection.Flattened(corners);
  struct Hole {
    std::vector<std::uint32_t> corners;
    std::vector<FlatPoint> flat;
    std::size_t rightmost = 0;
  };
  std::vector<Hole> cut;
  for (std::vector<std::uint32_t>& hole : holes) {
    if (hole.size() < 3) continue;
    Hole one{std::move(hole), {}, 0};
    one.flat = projection.Flattened(one.corners);
    if (SignedArea(one.flat) > 0) {
      std::ranges::reverse(one.corners);
      std::ranges::reverse(one.flat);
    }
    for (std::size_t i = 0; i < one.flat.size(); ++i) {
      if (!Contains(flat, one.flat[i])) return false;
      if (one.flat[i].x > one.flat[one.rightmost].x) one.rightmost = i;
    }
    cut.push_back(std::move(one));
  }
  std::ranges::stable_sort(cut, [](const Hole& a, const Hole& b) {
    return a.flat[a.rightmost].x > b.flat[b.rightmost].x;
  });
  // each hole is joined to the outline by a cut, there and back
  for (const Hole& hole : cut) {
    const std::size_t seen = SeenFrom(flat, hole.flat[hole.rightmost]);
    if (seen == flat.size()) return false;
    std::vector<std::uint32_t> bridge;
    std::vector<FlatPoint> bridge_flat;
    for (std::size_t k = 0; k <= hole.corners.size(); ++k) {
      const std::size_t i = (hole.rightmost + k) % hole.corners.size();
      bridge.push_back(hole.corners[i]);
      bridge_flat.push_back(hole.flat[i]);
    }
    bridge.push_back(corners[seen]);
    bridge_flat.push_back(flat[seen]);
    const auto behind = static_cast<std::ptrdiff_t>(seen + 1);
    corners.insert(corners.begin() + behind, bridge.begin(), bridge.end());
    flat.insert(flat.begin() + behind, bridge_flat.begin(), bridge_flat.end());
  }
  CutEars(flat, corners, triangles);
  return true;
}

}  // namespace tandem
