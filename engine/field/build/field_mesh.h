#pragma once

#include <vector>

#include "engine/field/build/face_tree.h"
#include "engine/geometry/mesh/mesh_facing.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/build/inside_rows.h"
#include "engine/voxel/build/surface_bricks.h"

namespace tandem {

/// A mesh as a field is built from it: its solid and its faces.
class FieldMesh {
 public:
  FieldMesh(const TriangleMesh& mesh_W, const MeshFacing& facing, double voxel_size);
  FieldMesh(const FieldMesh&) = delete;
  FieldMesh& operator=(const FieldMesh&) = delete;

  /// Tells whether some of its bodies are open.
  bool open() const noexcept { return open_; }
  /// Returns the hyperchunks that it meets.
  const HyperchunkBox& box() const noexcept { return surface_.box(); }
  /// Returns V's origin, voxels from W's.
  GridIndex origin() const { return box().first * kHyperchunkSide; }
  const std::vector<FieldFace>& faces() const noexcept { return faces_; }
  const FaceTree& tree() const noexcept { return tree_; }

  /// Tells whether the centre of a voxel of V is in the solid, by the rows of crossings. Where a
  /// body is open they leave out voxels that the surface passes through.
  bool Solid(const GridIndex& voxel_V) const;

 private:
  SurfaceBricks surface_;
  InsideRows inside_;
  bool open_;
  std::vector<FieldFace> faces_;
  FaceTree tree_;
};

Bounds BoundsOfFace(const FieldFace& face);

}  // namespace tandem
