#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// A mesh ready for drawing: single precision, metres, in the frame of the mesh it was made from. A
/// vertex appears once for each smooth side it lies on.
struct ShadedMesh {
  struct Vertex {
    std::array<float, 3> p;
    std::array<float, 3> n;  // unit, outwards
  };
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> triangles;        // three vertices each
  std::vector<std::uint32_t> uncut_triangles;  // triangles before Refine(); empty: it cut none
  std::vector<std::uint32_t> edges;  // two vertices each: creases and rims, drawn as lines
};

/// Shades smoothly across edges whose sides meet at less than `crease_angle` (rad), sharply across
/// the others. Triangles of no area are left out.
ShadedMesh Shade(const TriangleMesh& mesh, double crease_angle);

inline constexpr double kCreaseAngle = 0.55;  // rad, 31.5 degrees

}  // namespace tandem
