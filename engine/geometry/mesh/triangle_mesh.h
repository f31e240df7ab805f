#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/spatial.h"

namespace tandem {

/// A welded triangle mesh: vertices with the same position are shared, so that connectivity defines
/// the bodies. It may be open, and may hold several bodies.
struct TriangleMesh {
  using Triangle = std::array<std::uint32_t, 3>;  // counter-clockwise seen from outside

  std::vector<Vec3> vertices;  // p_MV, m
  std::vector<Triangle> triangles;

  const Vec3& corner(std::size_t triangle, std::size_t k) const {
    return vertices[triangles[triangle][k]];
  }
};

/// Returns the smallest box round the vertices that triangles use.
Bounds BoundsOf(const TriangleMesh& mesh);

/// Returns the sum of its triangles' areas, m^2.
double SurfaceArea(const TriangleMesh& mesh);

/// Returns the mesh with its vertices taken from M to W.
TriangleMesh Transformed(const TriangleMesh& mesh, const Pose& X_WM);

/// Appends `part` to `whole`, keeping their vertices apart.
void Append(TriangleMesh& whole, const TriangleMesh& part);

}  // namespace tandem
