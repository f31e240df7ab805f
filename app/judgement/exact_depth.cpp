#include "app/judgement/exact_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {

namespace {

/// A triangle of the moving mesh, in the fixture's frame.
struct Piece {
  std::array<Vec3, 3> corners;
  double most = 0;  // m, no point of it is deeper

  bool operator<(const Piece& other) const { return most < other.most; }
};

/// Tells whether two facets share an edge, lie in one plane and are convex together.
bool AreAConvexQuadrangle(const Facet& one, const Facet& other) {
  const std::array<Vec3, 3> a{one.a, one.b, one.c};
  const std::array<Vec3, 3> b{other.a, other.b, other.c};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      // the edge from p to q of the one is that from q to p of the other
      const Vec3& p = a[i];
      const Vec3& q = a[(i + 1) % 3];
      if (p != b[(j + 1) % 3] || q != b[j]) continue;
      const Vec3& left = a[(i + 2) % 3];
      const Vec3& right = b[(j + 2) % 3];
      const double flat = 1e-9 * ((q - p).norm() + (right - p).norm());
      const auto turns_left = [&](const Vec3& from, const Vec3& by, const Vec3& to) {
        return one.nhat.dot((by - from).cross(to - by)) >= 0;
      };
      return std::abs(one.nhat.dot(right - p)) <= flat && turns_left(left, p, right) &&
             turns_left(p, right, q) && turns_left(right, q, left) && turns_left(q, left, p);
    }
  }
  return false;
}

/// Finds the deepest point.
class Search {
 public:
  Search(const ExactSurface& fixture, double at_least)
      : fixture_(fixture), deepest_(std::max(at_least, 0.0)) {}

  double deepest() const { return deepest_; }
  std::size_t looks() const { return looks_; }
  /// Returns how much deeper than the deepest point found any may be.
  double error() const { return open_.empty() ? 0 : std::max(0.0, open_.top().most - deepest_); }

  void Add(const std::array<Vec3, 3>& corners) {
    ++looks_;
    const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    double radius = 0;
    for (const Vec3& corner : corners) radius = std::max(radius, (corner - middle).norm());
    const double depth = fixture_.Depth(middle);
    deepest_ = std::max(deepest_, depth);
    const double most = std::min(depth + radius, MostFrom(Near(middle, corners), corners));
    if (most <= deepest_) return;
    // no point of a piece in a gap is inside
    if (depth < 0 && !fixture_.MayMeet(corners)) return;
    open_.push({corners, most});
  }

  void SplitTheMostPromising() {
    const Piece piece = open_.top();
    open_.pop();
    const auto& [a, b, c] = piece.corners;
    const Vec3 ab = (a + b) / 2;
    const Vec3 bc = (b + c) / 2;
    const Vec3 ca = (c + a) / 2;
    for (const std::array<Vec3, 3>& part : {std::array{a, ab, ca}, std::array{ab, b, bc},
                                            std::array{ca, bc, c}, std::array{ab, bc, ca}}) {
      Add(part);
    }
  }

 private:
  /// A facet, or two that are one convex quadrangle.
  struct Face {
    const Facet* first = nullptr;
    const Facet* second = nullptr;
  };

  /// Returns the face near a triangle: the facet closest to its middle, and the one closest to a
  /// corner that completes it.
  Face Near(const Vec3& middle, const std::array<Vec3, 3>& corners) const {
    Face face{&fixture_.ClosestFacet(middle), nullptr};
    for (const Vec3& corner : corners) {
      const Facet& other = fixture_.ClosestFacet(corner);
      if (&other == face.first || !AreAConvexQuadrangle(*face.first, other)) continue;
      face.second = &other;
      break;
    }
    return face;
  }

  /// Returns the greatest distance of a triangle's points from a face. The distance from a convex
  /// shape is greatest at a corner.
  static double MostFrom(const Face& face, const std::array<Vec3, 3>& corners) {
    const auto distance = [](const Facet& facet, const Vec3& p) {
      return (p - ClosestOnTriangle(facet.a, facet.b, facet.c, p).point).norm();
    };
    double most = 0;
    for (const Vec3& corner : corners) {
      double there = distance(*face.first, corner);
      if (face.second != nullptr) there = std::min(there, distance(*face.second, corner));
      most = std::max(most, there);
    }
    return most;
  }

  const ExactSurface& fixture_;
  double deepest_;
  std::size_t looks_ = 0;
  std::priority_queue<Piece> open_;
};

}  // namespace

BoundedDepth GreatestDepth(const ExactSurface& fixture_F, const TriangleMesh& moving_B,
                           const Pose& X_FB, double at_least, double tolerance,
                           std::size_t most_looks) {
  if (fixture_F.empty()) return {at_least, 0};
  if (moving_B.triangles.size() > most_looks) {
    return {at_least, std::numeric_limits<double>::infinity()};
  }
  Search search(fixture_F, at_least);
  const auto at = [&](std::uint32_t vertex) {
    return X_FB * moving_B.vertices[vertex];
  };
  for (const TriangleMesh::Triangle& t : moving_B.triangles) {
    search.Add({at(t[0]), at(t[1]), at(t[2])});
  }
  while (search.error() > tolerance && search.looks() < most_looks) search.SplitTheMostPromising();
  return {search.deepest(), search.error()};
}

}  // namespace tandem
