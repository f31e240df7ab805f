#pragma once

#include <vector>

#include "engine/base/spatial.h"
#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A place of a body's surface that another body can lean on: a vertex, or the middle of a part of
/// an edge. Lengths are in voxels, axes are those of W.
struct FeaturePoint {
  Vec3 place_W = Vec3::Zero();
  Vec3 outward = Vec3::Zero();  // unit
  Vec3 tangent = Vec3::Zero();  // unit, along an edge's part; zero for a vertex
  double half_length = 0;       // half length of an edge's part
  /// For an edge's part, as FeatureNormals::edge_cosines, which is at least 0.
  double cosine = 1;
  bool ends = false;  // the part ends at a vertex, which the tangent points away from

  bool is_edge() const { return half_length > 0; }
};

/// Finds the vertices and edges of a mesh that another body can lean on: edges that bulge, rims of
/// open sheets, and the vertices at which such edges end. When two polyhedra first touch, a vertex
/// of this kind touches a face, or two edges of this kind cross. So notches and flat subdivisions
/// are left out. Where the surface bulges within the polygons of the features, points of
/// AddCrownPoints() follow.
///
/// The function cuts an edge into parts of at most `spacing` voxels. Mesh edges that continue as
/// one line count as one edge. `features` are those of `mesh_W`, whose triangles face outward. The
/// result is deterministic.
std::vector<FeaturePoint> FindFeaturePoints(const TriangleMesh& mesh_W, const Features& features,
                                            double voxel_size, double spacing);

}  // namespace tandem
