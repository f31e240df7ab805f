#include "engine/voxel/points/surface_voxels.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "engine/voxel/build/triangles/triangle_rows.h"

namespace tandem {

namespace {

constexpr int kChunkBits = kSnapBits + 3;  // snapped units across a chunk

struct Entry {
  std::uint64_t code;  // code of the chunk
  GridIndex chunk;
  std::uint32_t triangle;

  bool operator<(const Entry& other) const {
    return code != other.code ? code < other.code : triangle < other.triangle;
  }
};

/// Finds the chunks that each triangle meets, as voxels are found in a hyperchunk.
std::vector<Entry> BinByChunk(const std::vector<SnappedTriangle>& triangles) {
  constexpr std::size_t kBlock = 8192;
  std::vector<std::vector<Entry>> blocks((triangles.size() + kBlock - 1) / kBlock);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    std::vector<std::uint64_t> met(kBrickRows + TriangleRows::kPadding, 0);
    const std::size_t end = std::min(triangles.size(), (b + 1) * kBlock);
    for (std::size_t t = b * kBlock; t < end; ++t) {
      const TriangleRows rows(triangles[t], kChunkBits);
      const GridIndex lowest = rows.lowest();
      const GridIndex highest = rows.highest();
      const auto add = [&](const GridIndex& chunk) {
        blocks[b].push_back({MortonCode(chunk), chunk, static_cast<std::uint32_t>(t)});
      };
      if (lowest == highest) {
        add(lowest);
        continue;
      }
      for (std::int32_t z = lowest.z; z <= highest.z; z += kHyperchunkSide) {
        for (std::int32_t y = lowest.y; y <= highest.y; y += kHyperchunkSide) {
          for (std::int32_t x = lowest.x; x <= highest.x; x += kHyperchunkSide) {
            rows.Mark({x, y, z}, met.data(), 0, nullptr);
            const std::int32_t rows_y = std::min(kHyperchunkSide, highest.y - y + 1);
            const std::int32_t rows_z = std::min(kHyperchunkSide, highest.z - z + 1);
            for (std::int32_t row_z = 0; row_z < rows_z; ++row_z) {
              for (std::int32_t row_y = 0; row_y < rows_y; ++row_y) {
                std::uint64_t& row = met[static_cast<std::size_t>(row_y + kHyperchunkSide * row_z)];
                for (; row != 0; row &= row - 1) {
                  add({x + std::countr_zero(row), y + row_y, z + row_z});
                }
              }
            }
          }
        }
      }
    }
  });
  std::vector<Entry> entries;
  for (const std::vector<Entry>& block : blocks) {
    entries.insert(entries.end(), block.begin(), block.end());
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
      TriangleRows(triangles[t], kSnapBits).MarkChunk(chunk.place, chunk.bits);
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
