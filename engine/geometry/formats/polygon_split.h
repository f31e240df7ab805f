#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/geometry/mesh/weld.h"

namespace tandem {

/// Appends the triangles of a polygon. Its corners are numbers of points that all exist. It may be
/// concave, and need not be quite flat. A polygon that crosses itself is cut in some way, and
/// nothing of it is left out. Fewer than three corners are no surface.
void SplitPolygon(std::span<const FloatPoint> points, std::span<const std::uint32_t> corners,
                  std::vector<TriangleMesh::Triangle>& triangles);

}  // namespace tandem
