#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A mesh ready for drawing: single precision, metres, in the frame of its source mesh. A vertex
/// has one copy for each smooth side that it lies on.
struct ShadedMesh {
  struct Vertex {
    std::array<float, 3> p;
    std::array<float, 3> n;  // unit, outwards
  };
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> triangles;        // three vertices each
  std::vector<std::uint32_t> uncut_triangles;  // triangles before Refine(); empty: none was cut
  std::vector<std::uint32_t> edges;  // two vertices each: creases and rims, drawn as lines
};

/// Makes a mesh for drawing. Shades smoothly across edges whose sides meet at less than
/// `crease_angle` (rad), sharply across the others. Leaves out triangles of no area.
ShadedMesh Shade(const TriangleMesh& mesh, double crease_angle);

inline constexpr double kCreaseAngle = 0.55;  // rad, 31.5 degrees

}  // namespace tandem
