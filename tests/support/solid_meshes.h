#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem::testing {

inline constexpr double kPi = 3.14159265358979323846;

/// Returns a closed box between two corners, 12 triangles.
inline TriangleMesh BoxBetween(const Vec3& min, const Vec3& max) {
  TriangleMesh mesh;
  for (unsigned i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1U) != 0 ? max.x() : min.x(), (i & 2U) != 0 ? max.y() : min.y(),
                               (i & 4U) != 0 ? max.z() : min.z());
  }
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

/// Returns a closed box about the origin.
inline TriangleMesh BoxOfHalf(const Vec3& half) {
  return BoxBetween(-half, half);
}

/// Returns a closed surface of revolution about z: `rings` rings of `around` vertices at radius(i),
/// height(i), heights rising, and a fan to a pole on the axis at either end.
template <typename Radius, typename Height>
TriangleMesh Revolved(std::uint32_t rings, std::uint32_t around, const Radius& radius,
                      const Height& height, double bottom, double top) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < rings; ++i) {
    for (std::uint32_t k = 0; k < around; ++k) {
      const double angle = 2 * kPi * k / around;
      mesh.vertices.emplace_back(radius(i) * std::cos(angle), radius(i) * std::sin(angle),
                                 height(i));
    }
  }
  const std::uint32_t poles = rings * around;
  mesh.vertices.emplace_back(0, 0, bottom);
  mesh.vertices.emplace_back(0, 0, top);
  for (std::uint32_t k = 0; k < around; ++k) {
    const std::uint32_t next = (k + 1) % around;
    mesh.triangles.push_back({poles, next, k});
    for (std::uint32_t at = 0; at + around < poles; at += around) {
      mesh.triangles.push_back({at + k, at + next, at + around + next});
      mesh.triangles.push_back({at + k, at + around + next, at + around + k});
    }
    mesh.triangles.push_back({poles + 1, poles - around + k, poles - around + next});
  }
  return mesh;
}

/// Returns a closed sphere of meridians and parallels, its vertices on the sphere.
inline TriangleMesh GlobeMesh(double radius, std::uint32_t around) {
  const std::uint32_t rings = around / 2 - 1;
  const auto polar = [rings](std::uint32_t i) {
    return kPi * (i + 1) / (rings + 1);
  };
  return Revolved(
      rings, around,
      [&](std::uint32_t i) {
        return radius * std::sin(polar(i));
      },
      [&](std::uint32_t i) {
        return -radius * std::cos(polar(i));
      },
      -radius, radius);
}

/// Returns a closed prism about z, from -half_length to half_length.
inline TriangleMesh Prism(double radius, double half_length, std::uint32_t around,
                          std::uint32_t rings = 2) {
  return Revolved(
      rings, around,
      [&](std::uint32_t) {
        return radius;
      },
      [&](std::uint32_t i) {
        return half_length * (2.0 * i / (rings - 1) - 1.0);
      },
      -half_length, half_length);
}

inline TriangleMesh TurnedInsideOut(TriangleMesh mesh) {
  for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

}  // namespace tandem::testing
