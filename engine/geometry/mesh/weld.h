#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

/// A position as in mesh files.
using FloatPoint = std::array<float, 3>;

/// The points that are the same vertex. Vertices are numbered in the order of their first points.
struct Weld {
  std::vector<std::uint32_t> vertex_of_point;
  std::vector<std::uint32_t>
      /// Per vertex: the point at which the vertex stands.
      first_point;
};

/// Welds points whose coordinates are equal (-0 equals 0). The points must be finite, and fewer
/// than 2^32 - 1.
Weld WeldEqual(std::span<const FloatPoint> points);

/// Welds each point to the first vertex within `tolerance` of it, if there is one. So no point
/// moves farther than that, and no chain of close points shrinks to one vertex. 0 welds equal
/// points only.
Weld WeldNear(std::span<const FloatPoint> points, double tolerance);

}  // namespace tandem
