#pragma once

#include <vector>

#include "engine/base/spatial.h"
#include "engine/geometry/facets.h"
#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// A place of a body's surface that another body can lean on: a vertex, or the middle of a part of
/// an edge. Lengths in voxels, axes of W.
struct FeaturePoint {
  Vec3 place_W = Vec3::Zero();
  Vec3 outward = Vec3::Zero();  // unit
  Vec3 tangent = Vec3::Zero();  // unit, of an edge's part; zero of a vertex
  double half_length = 0;       // of an edge's part
  /// An edge's part has that of FeatureNormals::edge_cosines, which is at least 0.
  double cosine = 1;
  bool ends = false;  // the part ends at a vertex, which the tangent points away from

  bool is_edge() const { return half_length > 0; }
};

/// The vertices and edges of a mesh that another body can lean on: edges that bulge, rims of open
/// sheets, and the vertices at which such edges end. Of two polyhedra that first touch, a vertex of
/// this kind touches a face or two edges of this kind cross, so notches and flat subdivisions tell
/// nothing. Where the surface bulges within the polygons of the features, points as of
/// AddCrownPoints() come after them.
///
/// An edge is cut into parts of at most `spacing` voxels; mesh edges that go on as one line are
/// one. `features` are those of `mesh_W`, whose triangles face outward. The same result every time.
std::vector<FeaturePoint> FindFeaturePoints(const TriangleMesh& mesh_W, const Features& features,
                                            double voxel_size, double spacing);

}  // namespace tandem
