#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/mesh_sides.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The edges and vertices of a mesh at a given accuracy (paper §4.1). Fine tessellation puts an
/// edge into most voxels, so features are those of coarser, quasi-planar polygons. The shape itself
/// stays as it is.
struct Features {
  std::vector<std::array<std::uint32_t, 2>>
      edges;                              // mesh edges between polygons, lesser index first
  std::vector<std::uint32_t> vertices;    // rising
  std::vector<std::uint32_t> polygon_of;  // per triangle
  std::size_t polygons = 0;
};

/// Merges triangles into polygons whose vertices all lie within `tolerance` (m) of one plane, the
/// area-weighted mean plane of their triangles. No triangle is turned 90 degrees or more from it
/// (docs/decisions/0008-labels.md). The paper tests against the last neighbour only, which would
/// roll a fine cylinder into one polygon; its tolerance is half a voxel.
///
/// A polygon grows from the largest triangle left, by the neighbour that is turned least. It stops
/// at open, non-manifold and inconsistently wound edges. Feature edges are the mesh edges between
/// polygons and those three kinds. Feature vertices are the ends of feature edges, except where
/// just two edges of the same pair of polygons meet. A vertex also stands where a line of such
/// edges leaves its chord by more than the tolerance. The result is deterministic.
Features FindFeatures(const TriangleMesh& mesh, double tolerance);
Features FindFeatures(const TriangleMesh& mesh, const MeshSides& sides, double tolerance);

}  // namespace tandem
