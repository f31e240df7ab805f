#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/mesh_facing.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/build/surface_bricks.h"
#include "engine/voxel/map/voxmap_image.h"

namespace tandem {

/// Finds which voxels lie inside a mesh. It ignores surface voxels, so the result does not depend
/// on where in its voxel the surface passes.
///
/// A voxel is inside if the mesh's closed bodies go round its centre more often outward than
/// inward. So overlapping and self-crossing bodies are united, and a cavity is subtracted. The
/// number is counted from the surface's crossings along rows of centres, carried from hyperchunk to
/// hyperchunk along x, and is exact. Open bodies are decided by their generalized winding number,
/// which closes holes as a soap film would.
class InsideRows {
 public:
  InsideRows(const SurfaceBricks& bricks, const TriangleMesh& mesh_W, const MeshFacing& facing,
             double voxel_size);

  /// Returns the kBrickRows rows of a hyperchunk, by cell of the bricks' box; null where all are
  /// alike.
  const std::uint64_t* RowsOf(std::size_t cell) const noexcept { return rows_of_[cell]; }
  /// Tells whether a hyperchunk without rows lies inside throughout.
  bool Solid(std::size_t cell) const noexcept { return solid_[cell] != 0; }

 private:
  void CountCrossings(const SurfaceBricks& bricks);
  void AddOpenBodies(const SurfaceBricks& bricks, const TriangleMesh& mesh_W,
                     const MeshFacing& facing, double voxel_size);

  ImageBytes rows_;                                // rows of the bricks
  std::vector<std::vector<std::uint64_t>> wound_;  // rows of hyperchunks that an open body reaches
  std::vector<const std::uint64_t*> rows_of_;
  std::vector<std::uint8_t> solid_;
};

}  // namespace tandem
