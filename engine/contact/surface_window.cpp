#include "engine/contact/surface_window.h"

#include <algorithm>
#include <bit>

namespace tandem {

namespace {

/// The cells of one z of a chunk with x and y in ranges, which may lie partly outside.
std::uint64_t CellsWithin(std::int32_t x0, std::int32_t x1, std::int32_t y0, std::int32_t y1) {
  const auto bits = [](std::int32_t from, std::int32_t to) -> unsigned {
    from = std::max(from, 0);
    to = std::min(to, kChunkSide - 1);
    return from > to ? 0U : (2U << to) - (1U << from);
  };
  const std::uint64_t row = bits(x0, x1);
  std::uint64_t cells = 0;
  for (unsigned rows = bits(y0, y1); rows != 0; rows &= rows - 1) {
    cells |= row << (8 * std::countr_zero(rows));
  }
  return cells;
}

const SurfaceVoxels::Bits& SourcesOf(const SurfaceDetails::Chunk& chunk, Field field) {
  switch (field) {
    case Field::kVertex:
      return chunk.vertices;
    case Field::kEdge:
      return chunk.edges;
    case Field::kSurface:
      break;
  }
  return chunk.bits;
}

}  // namespace

template <bool hole>
std::span<const SurfaceWindow::Piece> SurfaceWindow::List(const GridIndex& voxel_V,
                                                          const GridIndex& low,
                                                          const GridIndex& high,
                                                          Field field) noexcept {
  std::size_t count = 0;
  const auto& size = voxmap_->header().size;
  const auto last = [&](std::size_t axis, std::int32_t at) {
    return std::min(at >> 3, static_cast<std::int32_t>(8 * size[axis]) - 1);
  };
  for (std::int32_t cz = std::max(low.z >> 3, 0); cz <= last(2, high.z); ++cz) {
    for (std::int32_t cy = std::max(low.y >> 3, 0); cy <= last(1, high.y); ++cy) {
      for (std::int32_t cx = std::max(low.x >> 3, 0); cx <= last(0, high.x); ++cx) {
        const SurfaceDetails::Chunk* chunk = details_->At(*voxmap_, {cx, cy, cz});
        if (chunk == nullptr) continue;
        const SurfaceVoxels::Bits& sources = SourcesOf(*chunk, field);
        const GridIndex first = GridIndex{cx, cy, cz} * kChunkSide;
        const GridIndex from = low - first;
        const GridIndex to = high - first;
        const GridIndex at = voxel_V - first;
        const std::uint64_t within = CellsWithin(from.x, to.x, from.y, to.y);
        const std::uint64_t inner = hole ? CellsWithin(at.x - 1, at.x + 1, at.y - 1, at.y + 1) : 0;
        const std::int32_t z1 = std::min(to.z, kChunkSide - 1);
        for (std::int32_t z = std::max(from.z, 0); z <= z1; ++z) {
          const auto word = static_cast<std::size_t>(z);
          std::uint64_t cells = sources[word] & within;
          if (z >= at.z - 1 && z <= at.z + 1) cells &= ~inner;
          for (; cells != 0; cells &= cells - 1) {
            const std::size_t cell = 64 * word + static_cast<std::size_t>(std::countr_zero(cells));
            const GridIndex voxel = first + BlockCell(cell);
            const std::uint64_t bit = std::uint64_t{1} << (cell & 63);
            const bool edges = field == Field::kEdge;
            // a vertex voxel has edges, but no one that is its own
            if (!edges || (chunk->vertices[word] & bit) == 0) {
              pieces_[count++] = {voxel, &details_->Of(*chunk, cell)};
            }
            if (field == Field::kVertex || (chunk->forked[word] & bit) == 0) continue;
            for (const SurfaceDetails::MoreEdge& edge : details_->MoreEdges(*chunk, cell)) {
              pieces_[count++] = {voxel, &edge.detail, edge.ends};
            }
          }
        }
      }
    }
  }
  return {pieces_.data(), count};
}

std::span<const SurfaceWindow::Piece> SurfaceWindow::Near(const GridIndex& voxel_V,
                                                          Field field) noexcept {
  return List<false>(voxel_V, voxel_V - GridIndex{1, 1, 1}, voxel_V + GridIndex{1, 1, 1}, field);
}

std::span<const SurfaceWindow::Piece> SurfaceWindow::Round(const GridIndex& voxel_V,
                                                           const GridIndex& below,
                                                           const GridIndex& above,
                                                           Field field) noexcept {
  return List<true>(voxel_V, voxel_V - below, voxel_V + above, field);
}

}  // namespace tandem
