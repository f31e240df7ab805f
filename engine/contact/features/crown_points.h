#pragma once

#include <vector>

#include "engine/contact/features/feature_points.h"
#include "engine/geometry/mesh/mesh_sides.h"

namespace tandem {

/// Voxels that a convex surface may stand out from the plane on its feature points: force begins at
/// most this much late.
inline constexpr double kMostStandingOut = 0.03;

/// Adds places to a mesh's feature points where the mesh stands out from them. The polygons of
/// features are flat only within their tolerance, and the lines between them straight. So a vertex
/// of a finely cut round body lies up to twice as far beyond the points round it. A plane that
/// comes down on it would be met late.
///
/// The function adds vertices, and places at most a voxel apart along edges within polygons that
/// bulge. Each counts as a vertex. `mesh_W`, whose triangles face outward, and `sides` belong
/// together. The result is deterministic.
void AddCrownPoints(const TriangleMesh& mesh_W, const MeshSides& sides, double voxel_size,
                    std::vector<FeaturePoint>& points);

}  // namespace tandem
