#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry/facets.h"
#include "engine/geometry/feature_normals.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/surface_voxels.h"

namespace tandem {

/// The exact surface in one surface voxel, as far as points and planes are made from it (VPS.md
/// §3.2, §4.6). Lengths in voxels, places from the voxel's lowest corner, axes of W.
struct VoxelSurface {
  static constexpr std::size_t kMostSides = 4;

  std::uint16_t cell = 0;  // place in its chunk, as CellInBlock
  Label label = Label::kSurface;
  /// The feature vertex; or the middle of the feature edge's part; or the centre of the area.
  Vec3 place = Vec3::Zero();
  Vec3 tangent = Vec3::Zero();  // unit, of an edge voxel's longest edge
  double half_length = 0;       // of its part in the voxel
  double cosine = 0;            // as FeatureNormals::edge_cosines
  /// Outward unit normals: one, the mean over the area in the voxel; or where the facets face apart
  /// (a thin sheet) one for each side.
  std::array<Vec3, kMostSides> normals{};
  std::size_t sides = 0;
  /// Of a vertex or edge as a whole, wherever in the voxel it lies; of a surface the first normal.
  Vec3 feature_normal = Vec3::Zero();
};

/// Of every surface voxel of a chunk, by rising cell; none for voxels that only facets without area
/// meet.
std::vector<VoxelSurface> SurfacesOfChunk(const FeatureVoxels& voxels,
                                          const SurfaceVoxels::Chunk& chunk,
                                          const TriangleMesh& mesh_W, const Features& features,
                                          const FeatureNormals& normals);

}  // namespace tandem
