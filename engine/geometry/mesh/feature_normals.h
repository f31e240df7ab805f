#pragma once

#include <vector>

#include "engine/geometry/mesh/facets.h"

namespace tandem {

/// Outward unit normals of features, as the mean of their surroundings. For an edge it is the mean
/// of the two triangles', for a vertex the mean of all triangles round it, weighted by their angles
/// there.
struct FeatureNormals {
  std::vector<Vec3> edges;
  /// Cosine of the angle between an edge's normal and that of either triangle. A body that leans on
  /// the edge pushes within that angle of its normal. Negative in a notch, where nothing can lean;
  /// 0 at an edge of one triangle, or of more than two.
  std::vector<double> edge_cosines;
  std::vector<Vec3> vertices;
};
FeatureNormals FindFeatureNormals(const TriangleMesh& mesh, const Features& features);

}  // namespace tandem
