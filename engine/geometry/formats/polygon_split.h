#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/formats/raw_mesh.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Appends the triangles of a polygon. Its corners are numbers of points that all exist. It may be
/// concave, and need not be quite flat. A polygon that crosses itself is cut in some way, and
/// nothing of it is left out; one that goes round several times counts once. Fewer than three
/// corners are no surface.
void SplitPolygon(std::span<const FilePoint> points, std::span<const std::uint32_t> corners,
                  std::vector<TriangleMesh::Triangle>& triangles);

/// Does the same for a polygon with holes, whose corners `holes` have. Returns false, and appends
/// nothing, where a hole does not lie within the polygon.
bool SplitPolygonWithHoles(std::span<const FilePoint> points, std::vector<std::uint32_t> corners,
                           std::vector<std::vector<std::uint32_t>> holes,
                           std::vector<TriangleMesh::Triangle>& triangles);

}  // namespace tandem
