#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem::testing {

/// Returns the distance of p from a segment.
inline double FromSegment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp(along.dot(p - a) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

/// Returns the distance of p from a triangle: the height where p stands over it, else that of an
/// edge.
inline double FromTriangle(const std::array<Vec3, 3>& corners, const Vec3& p) {
  double distance = std::numeric_limits<double>::infinity();
  const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  bool over = normal.squaredNorm() > 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& a = corners[k];
    const Vec3& b = corners[(k + 1) % 3];
    distance = std::min(distance, FromSegment(a, b, p));
    over = over && normal.cross(b - a).dot(p - a) >= 0;
  }
  return over ? std::abs(normal.normalized().dot(p - corners[0])) : distance;
}

/// Every triangle of closed bodies that do not meet, one after another: no tree, no grid.
class BruteDistance {
 public:
  explicit BruteDistance(const TriangleMesh& mesh) {
    double area = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      triangles_.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
      const auto& [a, b, c] = triangles_.back();
      area += 0.5 * (b - a).cross(c - a).norm();
      area_to_.push_back(area);
    }
  }

  /// Returns the distance whatever the side, m.
  double Unsigned(const Vec3& p) const {
    double distance = std::numeric_limits<double>::infinity();
    for (const auto& triangle : triangles_)
      distance = std::min(distance, FromTriangle(triangle, p));
    return distance;
  }
  /// Judges by the solid angle of all triangles.
  bool Contains(const Vec3& p) const {
    double angle = 0;
    for (const auto& [a, b, c] : triangles_) {
      const Vec3 x = a - p;
      const Vec3 y = b - p;
      const Vec3 z = c - p;
      const double below = x.norm() * y.norm() * z.norm() + x.dot(y) * z.norm() +
                           y.dot(z) * x.norm() + z.dot(x) * y.norm();
      angle += 2 * std::atan2(x.dot(y.cross(z)), below);
    }
    return angle > 2 * std::numbers::pi;
  }
  /// Returns the distance, negative inside, m.
  double Signed(const Vec3& p) const { return Contains(p) ? -Unsigned(p) : Unsigned(p); }

  /// Returns a place at most `reach` from the surface, evenly over its area.
  Vec3 PlaceNear(double reach, std::mt19937_64& random) const {
    std::uniform_real_distribution<double> one(0, 1);
    std::normal_distribution<double> normal;
    const auto at =
        std::lower_bound(area_to_.begin(), area_to_.end(), one(random) * area_to_.back());
    const auto& [a, b, c] = triangles_[std::min(triangles_.size() - 1,
                                                static_cast<std::size_t>(at - area_to_.begin()))];
    double u = one(random);
    double v = one(random);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Vec3 way(normal(random), normal(random), normal(random));
    return a + u * (b - a) + v * (c - a) + reach * one(random) * way.normalized();
  }

 private:
  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<double> area_to_;  // m^2; area of the triangles so far
};

}  // namespace tandem::testing
