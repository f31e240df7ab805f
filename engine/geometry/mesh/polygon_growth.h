#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/mesh_sides.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Finds the quasi-planar polygons of FindFeatures() (paper §4.1), without the edges between them:
/// the polygon of each triangle. Returns the number of polygons. The result is the same for any
/// number of threads.
std::uint32_t GrowPolygons(const TriangleMesh& mesh, const MeshSides& sides, double tolerance,
                           std::vector<std::uint32_t>& polygon_of);

}  // namespace tandem
