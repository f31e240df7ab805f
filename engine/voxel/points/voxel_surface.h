#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/feature_normals.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/points/surface_voxels.h"

namespace tandem {

/// The exact surface in one surface voxel, as far as points and planes need it (decisions 0008,
/// 0010). Lengths are in voxels, places from the voxel's lowest corner, axes those of W.
struct VoxelSurface {
  static constexpr std::size_t kMostSides = 4;
  static constexpr std::size_t kMostMoreEdges = 6;  // the longest of them

  std::uint16_t cell = 0;  // place in its chunk, as CellInBlock
  Label label = Label::kSurface;
  /// The feature vertex, or the middle of the feature edge's part, or the centre of the area.
  Vec3 place = Vec3::Zero();
  Vec3 tangent = Vec3::Zero();  // unit, along an edge voxel's longest edge
  double half_length = 0;       // half length of its part in the voxel; 0 for other voxels
  double cosine = 0;            // as FeatureNormals::edge_cosines
  /// For an edge in a vertex voxel: it ends at the vertex, which the tangent points away from.
  bool ends = false;
  /// Outward unit normals: one, the mean over the area in the voxel; or one for each side where the
  /// facets face apart (a thin sheet).
  std::array<Vec3, kMostSides> normals{};
  std::size_t sides = 0;
  /// Normal of a vertex or edge as a whole, wherever in the voxel it lies; for a surface the first
  /// normal.
  Vec3 feature_normal = Vec3::Zero();
};

struct ChunkSurfaces {
  /// Every surface voxel, by rising cell; none for voxels that only facets without area meet.
  std::vector<VoxelSurface> voxels;
  /// The sharp edges in voxels that already have a vertex, or a longer edge: each with its part
  /// there, as if it had the voxel alone; by rising cell. Edges that continue as one line count as
  /// one.
  std::vector<VoxelSurface> more_edges;
};
ChunkSurfaces SurfacesOfChunk(const FeatureVoxels& voxels, const SurfaceVoxels::Chunk& chunk,
                              const TriangleMesh& mesh_W, const Features& features,
                              const FeatureNormals& normals);

}  // namespace tandem
