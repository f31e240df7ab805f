#include "engine/voxel/surface_voxels.h"

#include <bit>
#include <numeric>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

namespace tandem {

namespace {

constexpr int kChunkBits = kSnapBits + 3;  // snapped units across a chunk

struct Entry {
  std::uint64_t code;  // of the chunk
  GridIndex chunk;
  std::uint32_t triangle;

  bool operator<(const Entry& other) const {
    return code != other.code ? code < other.code : triangle < other.triangle;
  }
};

/// The chunks that each triangle meets, tested in blocks of 8 x 8 x 8 chunks as voxels are in a
/// chunk.
std::vector<Entry> BinByChunk(const std::vector<SnappedTriangle>& triangles) {
  std::vector<Entry> entries;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const TriangleOverlap overlap(triangles[t]);
    const GridIndex lowest = overlap.LowestCell(kChunkBits) >> 3;
    const GridIndex highest = overlap.HighestCell(kChunkBits) >> 3;
    for (std::int32_t z = lowest.z; z <= highest.z; ++z) {
      for (std::int32_t y = lowest.y; y <= highest.y; ++y) {
        for (std::int32_t x = lowest.x; x <= highest.x; ++x) {
          std::array<std::uint64_t, 8> met{};
          overlap.MarkBlock({x, y, z}, kChunkBits, met);
          for (std::size_t word = 0; word < 8; ++word) {
            for (std::uint64_t rest = met[word]; rest != 0; rest &= rest - 1) {
              const std::size_t cell = 64 * word + static_cast<std::size_t>(std::countr_zero(rest));
              const GridIndex chunk = GridIndex{x, y, z} * kChunkSide + BlockCell(cell);
              entries.push_back({MortonCode(chunk), chunk, t});
            }
          }
        }
      }
    }
  }
  tbb::parallel_sort(entries.begin(), entries.end());
  return entries;
}

}  // namespace

std::vector<SnappedTriangle> SnapTriangles(const TriangleMesh& mesh_W, double voxel_size) {
  std::vector<SnappedPoint> points;
  points.reserve(mesh_W.vertices.size());
  for (const Vec3& vertex : mesh_W.vertices) points.push_back(Snap(vertex, voxel_size));
  std::vector<SnappedTriangle> triangles;
  triangles.reserve(mesh_W.triangles.size());
  for (const TriangleMesh::Triangle& t : mesh_W.triangles) {
    triangles.push_back({points[t[0]], points[t[1]], points[t[2]]});
  }
  return triangles;
}

SurfaceVoxels FindSurfaceVoxels(const std::vector<SnappedTriangle>& triangles, double voxel_size) {
  const std::vector<Entry> entries = BinByChunk(triangles);
  SurfaceVoxels surface;
  surface.voxel_size = voxel_size;
  surface.snapped = triangles;
  surface.triangles.reserve(entries.size());
  for (const Entry& entry : entries) {
    if (surface.chunks.empty() || !(surface.chunks.back().place == entry.chunk)) {
      surface.chunks.push_back(
          {.place = entry.chunk,
           .bits = {},
           .first_triangle = static_cast<std::uint32_t>(surface.triangles.size()),
           .triangle_count = 0});
    }
    surface.triangles.push_back(entry.triangle);
    ++surface.chunks.back().triangle_count;
  }
  tbb::parallel_for(std::size_t{0}, surface.chunks.size(), [&](std::size_t c) {
    SurfaceVoxels::Chunk& chunk = surface.chunks[c];
    for (const std::uint32_t t : surface.TrianglesOf(chunk)) {
      TriangleOverlap(triangles[t]).MarkBlock(chunk.place, kSnapBits, chunk.bits);
    }
  });
  surface.chunk_at.reserve(surface.chunks.size());
  for (std::uint32_t c = 0; c < surface.chunks.size(); ++c) {
    surface.chunk_at.emplace(surface.chunks[c].place, c);
  }
  return surface;
}

FeatureVoxels FindFeatureVoxels(const TriangleMesh& mesh_W, const Features& features,
                                double voxel_size) {
  const auto snapped = [&](std::uint32_t vertex) {
    return Snap(mesh_W.vertices[vertex], voxel_size);
  };
  std::vector<SnappedTriangle> edges;
  edges.reserve(features.edges.size());
  for (const auto& [a, b] : features.edges) edges.push_back({snapped(a), snapped(b), snapped(b)});
  std::vector<SnappedTriangle> vertices;
  vertices.reserve(features.vertices.size());
  for (const std::uint32_t v : features.vertices) {
    vertices.push_back({snapped(v), snapped(v), snapped(v)});
  }
  // a feature vertex is an edge's end; one on a cell's border is in the same cell for both
  FeatureVoxels found;
  found.of[0] = FindSurfaceVoxels(SnapTriangles(mesh_W, voxel_size), voxel_size);
  found.of[1] = FindSurfaceVoxels(edges, voxel_size);
  found.of[2] = FindSurfaceVoxels(vertices, voxel_size);
  return found;
}

}  // namespace tandem
