#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry/facets.h"
#include "engine/geometry/feature_normals.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/surface_voxels.h"

namespace tandem {

/// The exact surface in one surface voxel, as far as points and planes are made from it (decisions
/// 0008, 0010). Lengths in voxels, places from the voxel's lowest corner, axes of W.
struct VoxelSurface {
  static constexpr std::size_t kMostSides = 4;
  static constexpr std::size_t kMostMoreEdges = 6;  // the longest

  std::uint16_t cell = 0;  // place in its chunk, as CellInBlock
  Label label = Label::kSurface;
  /// The feature vertex; or the middle of the feature edge's part; or the centre of the area.
  Vec3 place = Vec3::Zero();
  Vec3 tangent = Vec3::Zero();  // unit, of an edge voxel's longest edge
  double half_length = 0;       // of its part in the voxel; 0 of other voxels
  double cosine = 0;            // as FeatureNormals::edge_cosines
  /// Of an edge in a vertex voxel: it ends at the vertex, which the tangent points away from.
  bool ends = false;
  /// Outward unit normals: one, the mean over the area in the voxel; or where the facets face apart
  /// (a thin sheet) one for each side.
  std::array<Vec3, kMostSides> normals{};
  std::size_t sides = 0;
  /// Of a vertex or edge as a whole, wherever in the voxel it lies; of a surface the first normal.
  Vec3 feature_normal = Vec3::Zero();
};

struct ChunkSurfaces {
  /// Of every surface voxel, by rising cell; none for voxels that only facets without area meet.
  std::vector<VoxelSurface> voxels;
  /// The sharp edges in voxels that have a vertex, or a longer edge, already: each with its part
  /// there, as if the voxel were its own; by rising cell. Edges that go on as one line are one.
  std::vector<VoxelSurface> more_edges;
};
ChunkSurfaces SurfacesOfChunk(const FeatureVoxels& voxels, const SurfaceVoxels::Chunk& chunk,
                              const TriangleMesh& mesh_W, const Features& features,
                              const FeatureNormals& normals);

}  // namespace tandem
