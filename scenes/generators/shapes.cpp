#include "scenes/generators/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <utility>

#include "engine/base/check.h"

namespace tandem {
namespace {

std::uint32_t Index(std::size_t i) {
  return static_cast<std::uint32_t>(i);
}

double SixVolumes(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    sum += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2)));
  }
  return sum;
}

Vec2 OnCircle(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

double AngleOf(int side, int sides) {
  return 2 * std::numbers::pi * side / sides;
}

double Cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Cuts ears off a simple counter-clockwise polygon until nothing is left.
std::vector<TriangleMesh::Triangle> Triangulated(const std::vector<Vec2>& polygon) {
  std::vector<std::size_t> left(polygon.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  std::vector<TriangleMesh::Triangle> triangles;
  while (left.size() > 2) {
    bool cut = false;
    for (std::size_t k = 0; k < left.size() && !cut; ++k) {
      const std::size_t before = left[(k + left.size() - 1) % left.size()];
      const std::size_t at = left[k];
      const std::size_t after = left[(k + 1) % left.size()];
      const Vec2& a = polygon[before];
      const Vec2& b = polygon[at];
      const Vec2& c = polygon[after];
      if (Cross(b - a, c - b) <= 0) continue;
      const bool empty = std::none_of(left.begin(), left.end(), [&](std::size_t other) {
        if (other == before || other == at || other == after) return false;
        const Vec2& p = polygon[other];
        return Cross(b - a, p - a) >= 0 && Cross(c - b, p - b) >= 0 && Cross(a - c, p - c) >= 0;
      });
      if (!empty) continue;
      triangles.push_back({Index(before), Index(at), Index(after)});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
      cut = true;
    }
    TANDEM_CHECK(cut);  // the polygon crosses itself or runs clockwise
  }
  return triangles;
}

// Returns the Catmull-Rom point: p1 at u = 0 and p2 at u = 1.
Vec3 Through(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& p3, double u) {
  const Vec3 a = 2 * p1;
  const Vec3 b = p2 - p0;
  const Vec3 c = 2 * p0 - 5 * p1 + 4 * p2 - p3;
  const Vec3 d = 3 * p1 - p0 - 3 * p2 + p3;
  return 0.5 * (a + u * (b + u * (c + u * d)));
}

}  // namespace

Loop Circle(double radius, double z, int sides) {
  Loop loop;
  for (int i = 0; i < sides; ++i) {
    const Vec2 at = radius * OnCircle(AngleOf(i, sides));
    loop.emplace_back(at.x(), at.y(), z);
  }
  return loop;
}

TriangleMesh TurnedOutward(TriangleMesh mesh) {
  if (SixVolumes(mesh) < 0) {
    for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

TriangleMesh Skin(const std::vector<Loop>& loops, SkinEnds ends) {
  TANDEM_CHECK(loops.size() >= 2);
  const std::size_t n = loops.front().size();
  TriangleMesh mesh;
  for (const Loop& loop : loops) {
    TANDEM_CHECK(loop.size() == n);
    mesh.vertices.insert(mesh.vertices.end(), loop.begin(), loop.end());
  }
  const std::size_t spans = ends == SkinEnds::kJoined ? loops.size() : loops.size() - 1;
  for (std::size_t k = 0; k < spans; ++k) {
    const std::size_t here = k * n;
    const std::size_t next = (k + 1) % loops.size() * n;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      mesh.triangles.push_back({Index(here + i), Index(here + j), Index(next + j)});
      mesh.triangles.push_back({Index(here + i), Index(next + j), Index(next + i)});
    }
  }
  if (ends == SkinEnds::kCapped) {
    const auto cap = [&](const Loop& loop, std::size_t first, bool ahead) {
      Vec3 centre = Vec3::Zero();
      for (const Vec3& p : loop) centre += p / static_cast<double>(n);
      const std::size_t middle = mesh.vertices.size();
      mesh.vertices.push_back(centre);
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t a = first + i;
        const std::size_t b = first + (i + 1) % n;
        mesh.triangles.push_back({Index(ahead ? a : b), Index(ahead ? b : a), Index(middle)});
      }
    };
    cap(loops.front(), 0, false);
    cap(loops.back(), (loops.size() - 1) * n, true);
  }
  return TurnedOutward(std::move(mesh));
}

TriangleMesh Revolved(const std::vector<Vec2>& profile, int sides) {
  std::vector<Loop> loops;
  for (const Vec2& p : profile) loops.push_back(Circle(p.x(), p.y(), sides));
  return Skin(loops, SkinEnds::kCapped);
}

TriangleMesh RevolvedRing(const std::vector<Vec2>& profile, int sides) {
  std::vector<Loop> loops;
  for (const Vec2& p : profile) loops.push_back(Circle(p.x(), p.y(), sides));
  return Skin(loops, SkinEnds::kJoined);
}

TriangleMesh Prism(const std::vector<Vec2>& polygon, double bottom, double top) {
  const std::size_t n = polygon.size();
  TriangleMesh mesh;
  for (const double z : {bottom, top}) {
    for (const Vec2& p : polygon) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    mesh.triangles.push_back({Index(i), Index(j), Index(n + j)});
    mesh.triangles.push_back({Index(i), Index(n + j), Index(n + i)});
  }
  for (const TriangleMesh::Triangle& t : Triangulated(polygon)) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({Index(n + t[0]), Index(n + t[1]), Index(n + t[2])});
  }
  return mesh;
}

TriangleMesh Box(const Vec3& min, const Vec3& max) {
  return Prism({{min.x(), min.y()}, {max.x(), min.y()}, {max.x(), max.y()}, {min.x(), max.y()}},
               min.z(), max.z());
}

TriangleMesh Hose(const std::vector<Vec3>& points, double radius, double ripple, int sides,
                  int segments_per_span) {
  std::vector<Vec3> curve;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vec3& before = points[k == 0 ? 0 : k - 1];
    const Vec3& after = points[std::min(k + 2, points.size() - 1)];
    for (int i = 0; i < segments_per_span; ++i) {
      curve.push_back(Through(before, points[k], points[k + 1], after,
                              static_cast<double>(i) / segments_per_span));
    }
  }
  curve.push_back(points.back());

  // a frame carried along the curve without twist
  std::vector<Loop> loops;
  Vec3 tangent = (curve[1] - curve[0]).normalized();
  Vec3 side = tangent.unitOrthogonal();
  for (std::size_t k = 0; k < curve.size(); ++k) {
    const Vec3 ahead = k + 1 < curve.size() ? curve[k + 1] : curve[k];
    const Vec3 behind = k > 0 ? curve[k - 1] : curve[k];
    const Vec3 now = (ahead - behind).normalized();
    side = (Quat::FromTwoVectors(tangent, now) * side).normalized();
    tangent = now;
    const Vec3 up = tangent.cross(side);
    const double r = radius + (k % 2 == 0 ? -ripple : ripple);
    Loop loop;
    for (int i = 0; i < sides; ++i) {
      const Vec2 at = r * OnCircle(AngleOf(i, sides));
      loop.emplace_back(curve[k] + at.x() * side + at.y() * up);
    }
    loops.push_back(std::move(loop));
  }
  return Skin(loops, SkinEnds::kCapped);
}

double Reach(const Outline& outline, double angle) {
  // the hull lies behind each of its tangent lines; the ray ends at the first of them
  constexpr int kTangents = 1440;
  double reach = 1e300;
  for (int i = 0; i < kTangents; ++i) {
    const double direction = AngleOf(i, kTangents);
    const double slope = std::cos(direction - angle);
    if (slope < 1e-6) continue;
    double support = -1e300;
    for (const Disc& disc : outline) {
      support = std::max(support, disc.centre.dot(OnCircle(direction)) + disc.radius);
    }
    reach = std::min(reach, support / slope);
  }
  return reach;
}

TriangleMesh Plate(const Outline& outline, const Outline& hole, double bottom, double top,
                   const PlateEdges& edges) {
  // directions evenly spread, and those of the outline's sharp corners
  std::vector<double> angles;
  for (int i = 0; i < edges.sides; ++i) angles.push_back(AngleOf(i, edges.sides));
  for (const Disc& disc : outline) {
    if (disc.radius > 0 || disc.centre.isZero()) continue;
    double corner = std::atan2(disc.centre.y(), disc.centre.x());
    if (corner < 0) corner += 2 * std::numbers::pi;
    angles.push_back(corner);
  }
  std::sort(angles.begin(), angles.end());
  const auto same = [](double a, double b) {
    return std::abs(a - b) < 1e-6;
  };
  angles.erase(std::unique(angles.begin(), angles.end(), same), angles.end());

  std::vector<Loop> loops;
  for (const double angle : angles) {
    const double near = Reach(hole, angle);
    const double far = Reach(outline, angle);
    Loop loop;
    // a corner of the profile, from the start of its arc to its end
    const auto corner = [&](double r, double z, double round, double inward, double down, bool up) {
      if (round <= 0) {
        loop.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
        return;
      }
      for (int i = 0; i <= edges.arc_steps; ++i) {
        const double turn =
            0.5 * std::numbers::pi * (up ? edges.arc_steps - i : i) / edges.arc_steps;
        const double at = r + inward * round * (1 - std::cos(turn));
        loop.emplace_back(at * std::cos(angle), at * std::sin(angle),
                          z + down * round * (1 - std::sin(turn)));
      }
    };
    corner(near, top, edges.hole_round, 1, -1, false);
    corner(far, top, edges.outer_round, -1, -1, true);
    corner(far, bottom, edges.outer_round, -1, 1, false);
    corner(near, bottom, edges.hole_round, 1, 1, true);
    loops.push_back(std::move(loop));
  }
  return Skin(loops, SkinEnds::kJoined);
}

TriangleMesh HexHead(double across_flats, double height) {
  constexpr int kSides = 48;
  const double apothem = 0.5 * across_flats;
  const auto ring = [&](double limit, double z) {
    Loop loop;
    for (int i = 0; i < kSides; ++i) {
      const double angle = AngleOf(i, kSides);
      const double off = std::remainder(angle, std::numbers::pi / 3);
      const double r = std::min(apothem / std::cos(off), limit);
      loop.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    return loop;
  };
  const double corner = apothem / std::cos(std::numbers::pi / 6);
  return Skin({ring(1.02 * apothem, 0), ring(1.02 * apothem, 0.1 * height),
               ring(corner, 0.1 * height + 0.04 * across_flats), ring(corner, 0.5 * height),
               ring(corner, 0.85 * height), ring(0.99 * apothem, height)},
              SkinEnds::kCapped);
}

TriangleMesh ThreadedEnd(double radius, double pitch, double length, int sides) {
  constexpr int kStepsPerTurn = 6;
  const int steps = static_cast<int>(std::ceil(kStepsPerTurn * length / pitch));
  std::vector<Loop> loops;
  for (int k = 0; k <= steps; ++k) {
    const double z = -length * k / steps;
    Loop loop;
    for (int i = 0; i < sides; ++i) {
      const double turn = static_cast<double>(i) / sides;
      const double phase = z / pitch - turn;
      const double depth =
          2 * std::abs(phase - std::round(phase));  // 0 at the crest, 1 at the root
      const double r = radius - 0.55 * pitch * depth;
      const Vec2 at = r * OnCircle(AngleOf(i, sides));
      loop.emplace_back(at.x(), at.y(), z);
    }
    loops.push_back(std::move(loop));
  }
  return Skin(loops, SkinEnds::kCapped);
}

TriangleMesh Moved(const TriangleMesh& mesh, const Vec3& by) {
  TriangleMesh moved = mesh;
  for (Vec3& vertex : moved.vertices) vertex += by;
  return moved;
}

TriangleMesh AlongX(const TriangleMesh& mesh) {
  TriangleMesh turned = mesh;
  for (Vec3& v : turned.vertices) v = Vec3(v.z(), v.x(), v.y());
  return turned;
}

TriangleMesh AlongY(const TriangleMesh& mesh) {
  TriangleMesh turned = mesh;
  for (Vec3& v : turned.vertices) v = Vec3(v.y(), v.z(), v.x());
  return turned;
}

TriangleMesh OctahedralSphere(double radius, int levels, bool lower_half) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, -1}};
  mesh.triangles = {{2, 0, 4}, {0, 3, 4}, {3, 1, 4}, {1, 2, 4}};
  if (!lower_half) {
    mesh.vertices.emplace_back(0, 0, 1);
    mesh.triangles.insert(mesh.triangles.end(), {{0, 2, 5}, {2, 1, 5}, {1, 3, 5}, {3, 0, 5}});
  }
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, fresh] =
          middles.try_emplace(std::minmax(a, b), Index(mesh.vertices.size()));
      if (fresh) mesh.vertices.emplace_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return found->second;
    };
    std::vector<TriangleMesh::Triangle> finer;
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      const std::uint32_t ab = middle(t[0], t[1]);
      const std::uint32_t bc = middle(t[1], t[2]);
      const std::uint32_t ca = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

TriangleMesh HalfCup(double inner_radius, double outer_radius, int levels) {
  TriangleMesh cup = OctahedralSphere(outer_radius, levels, true);
  TriangleMesh inside = OctahedralSphere(inner_radius, levels, true);
  const std::size_t offset = cup.vertices.size();
  for (TriangleMesh::Triangle& t : inside.triangles) std::swap(t[1], t[2]);
  Append(cup, inside);

  // the rims have equally many vertices, created in the same order, so they pair off by number
  std::map<double, std::uint32_t> rim;  // per angle
  for (std::size_t v = 0; v < offset; ++v) {
    const Vec3& p = cup.vertices[v];
    if (p.z() == 0) rim[std::atan2(p.y(), p.x())] = Index(v);
  }
  const auto inner = [offset](std::uint32_t v) {
    return Index(v + offset);
  };
  for (auto at = rim.begin(); at != rim.end(); ++at) {
    const auto next = std::next(at) == rim.end() ? rim.begin() : std::next(at);
    cup.triangles.push_back({at->second, next->second, inner(next->second)});
    cup.triangles.push_back({at->second, inner(next->second), inner(at->second)});
  }
  return cup;
}

}  // namespace tandem
