#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/build/snapped_point.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

struct GridIndexHash {
  std::size_t operator()(const GridIndex& i) const noexcept {
    return MortonCode(i) * 0x9e3779b97f4a7c15ULL;
  }
};

/// The voxels that a mesh's surface passes through, chunk by chunk, and the triangles that pass
/// through each chunk. Chunks stand in Morton order. The result is the same for any number of
/// threads.
struct SurfaceVoxels {
  using Bits = std::array<std::uint64_t, 8>;  // in the order of CellInBlock

  struct Chunk {
    GridIndex place;  // in chunks, from W's origin
    Bits bits{};
    std::uint32_t first_triangle = 0;  // index into `triangles`
    std::uint32_t triangle_count = 0;
  };

  double voxel_size = 0;
  std::vector<SnappedTriangle> snapped;
  std::vector<Chunk> chunks;
  std::vector<std::uint32_t> triangles;  // grouped by chunk, rising within it
  std::unordered_map<GridIndex, std::uint32_t, GridIndexHash> chunk_at;

  std::span<const std::uint32_t> TrianglesOf(const Chunk& chunk) const {
    return std::span(triangles).subspan(chunk.first_triangle, chunk.triangle_count);
  }
  /// Returns the bits of a chunk, or null.
  const Bits* BitsAt(const GridIndex& chunk) const {
    const auto found = chunk_at.find(chunk);
    return found == chunk_at.end() ? nullptr : &chunks[found->second].bits;
  }
};

std::vector<SnappedTriangle> SnapTriangles(const TriangleMesh& mesh_W, double voxel_size);

/// Finds the surface voxels, exactly for the snapped mesh, in parallel.
SurfaceVoxels FindSurfaceVoxels(const std::vector<SnappedTriangle>& triangles, double voxel_size);

/// The sources of the three fields (paper §4): the voxels that the surface, its feature edges and
/// its feature vertices lie in. Each contains the next: an edge is a triangle without height, a
/// vertex is one without length, and one exact test decides them all. `triangles` of the latter two
/// are numbers of Features::edges and ::vertices.
struct FeatureVoxels {
  std::array<SurfaceVoxels, kFields> of;  // per Field

  const SurfaceVoxels& surface() const { return of[0]; }
  const SurfaceVoxels& operator[](Field field) const { return of[static_cast<std::size_t>(field)]; }
};
FeatureVoxels FindFeatureVoxels(const TriangleMesh& mesh_W, const Features& features,
                                double voxel_size);

}  // namespace tandem
