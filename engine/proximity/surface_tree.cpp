#include "engine/proximity/surface_tree.h"

#include <utility>

namespace tandem {

namespace {

std::array<std::uint64_t, 8> SurfaceBits(const Voxmap& voxmap, std::uint32_t plane) {
  std::array<std::uint64_t, 8> bits{};
  for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
    const bool surface = voxmap.StoredMark(plane, cell) == kSurfaceMark;
    bits[cell >> 6] |= std::uint64_t{surface} << (cell & 63);
  }
  return bits;
}

}  // namespace

SurfaceTree::SurfaceTree(const Voxmap& voxmap) : voxel_size_(voxmap.voxel_size()) {
  if (voxmap.empty()) return;
  std::vector<Chunk> chunks;
  std::vector<Bounds> boxes;
  const auto& size = voxmap.header().size;
  std::size_t h = 0;
  for (std::uint32_t z = 0; z < size[2]; ++z) {
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      for (std::uint32_t x = 0; x < size[0]; ++x, ++h) {
        const std::uint32_t record = voxmap.index()[h];
        if (record == kRecordFar || record == kRecordSolid) continue;
        const GridIndex hyperchunk{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                                   static_cast<std::int32_t>(z)};
        for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
          const GridIndex chunk_V = hyperchunk * kChunkSide + BlockCell(c);
          const std::uint32_t plane = voxmap.PlaneOf(Field::kSurface, chunk_V);
          if (plane == kPlaneBeyond || plane == kPlaneInterior) continue;
          const Chunk chunk{voxmap.origin() + chunk_V * kChunkSide, SurfaceBits(voxmap, plane)};
          Bounds box;
          VisitCells(chunk.bits, [&](std::size_t cell) {
            box.Add(CentreOf(chunk.first + BlockCell(cell)));
            ++voxel_count_;
          });
          if (box.empty()) continue;
          chunks.push_back(chunk);
          boxes.push_back(box);
        }
      }
    }
  }
  tree_ = BuildBoxTree(boxes, 1);
  chunks_.reserve(chunks.size());
  for (const std::uint32_t i : tree_.order) chunks_.push_back(chunks[i]);
}

std::optional<Vec3> SurfaceTree::Nearest(const Vec3& p, double reach) const noexcept {
  double least = reach * reach;
  std::optional<Vec3> nearest;
  VisitNearLeaves(tree_, p, least, [&](const BoxTree::Node& leaf) {
    const Chunk& chunk = chunks_[leaf.first];
    VisitCells(chunk.bits, [&](std::size_t cell) {
      const Vec3 centre = CentreOf(chunk.first + BlockCell(cell));
      const double squared = (centre - p).squaredNorm();
      if (squared > least) return;
      least = squared;
      nearest = centre;
    });
    return least;
  });
  return nearest;
}

}  // namespace tandem
