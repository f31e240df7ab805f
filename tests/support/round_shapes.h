#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem::testing {

/// Returns a closed prism along y with these corners in z and x, counter-clockwise and all seen
/// from the axis. Its side is cut into `rings` rings.
inline TriangleMesh PrismAlongY(const std::vector<std::array<double, 2>>& corners, double length,
                                std::uint32_t rings = 1) {
  TriangleMesh mesh;
  const auto sides = static_cast<std::uint32_t>(corners.size());
  for (std::uint32_t ring = 0; ring <= rings; ++ring) {
    for (const auto& [z, x] : corners) {
      mesh.vertices.emplace_back(x, (static_cast<double>(ring) / rings - 0.5) * length, z);
    }
  }
  const auto low = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, -0.5 * length, 0);
  mesh.vertices.emplace_back(0, 0.5 * length, 0);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t next = (i + 1) % sides;
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
      const std::uint32_t at = ring * sides;
      mesh.triangles.push_back({at + i, at + next, at + sides + i});
      mesh.triangles.push_back({at + next, at + sides + next, at + sides + i});
    }
    mesh.triangles.push_back({low, next, i});
    mesh.triangles.push_back({low + 1, rings * sides + i, rings * sides + next});
  }
  return mesh;
}

/// Returns corners of a circle, for PrismAlongY(), from `begin` to `end` radians.
inline std::vector<std::array<double, 2>> Arc(double radius, std::uint32_t count, double begin,
                                              double end) {
  std::vector<std::array<double, 2>> corners;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = begin + (end - begin) * i / count;
    corners.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return corners;
}

/// Returns a closed cylinder along y, of `sides` flat sides.
inline TriangleMesh Cylinder(double radius, double length, std::uint32_t sides,
                             std::uint32_t rings = 1) {
  return PrismAlongY(Arc(radius, sides, 0, 2 * std::numbers::pi), length, rings);
}

}  // namespace tandem::testing
