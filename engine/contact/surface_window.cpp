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

template <int reach, int inner>
std::span<const SurfaceWindow::Piece> SurfaceWindow::List(const GridIndex& voxel_V,
                                                          Field field) noexcept {
  std::size_t count = 0;
  const GridIndex low = voxel_V - GridIndex{reach, reach, reach};
  const GridIndex high = voxel_V + GridIndex{reach, reach, reach};
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
        const GridIndex at = voxel_V - first;
        const std::uint64_t within =
            CellsWithin(at.x - reach, at.x + reach, at.y - reach, at.y + reach);
        const std::uint64_t hole =
            inner < 0 ? 0 : CellsWithin(at.x - inner, at.x + inner, at.y - inner, at.y + inner);
        const std::int32_t z1 = std::min(at.z + reach, kChunkSide - 1);
        for (std::int32_t z = std::max(at.z - reach, 0); z <= z1; ++z) {
          const auto word = static_cast<std::size_t>(z);
          std::uint64_t cells = sources[word] & within;
          if (z >= at.z - inner && z <= at.z + inner) cells &= ~hole;
          for (; cells != 0; cells &= cells - 1) {
            const std::size_t cell = 64 * word + static_cast<std::size_t>(std::countr_zero(cells));
            const GridIndex voxel = first + BlockCell(cell);
            const std::uint64_t bit = std::uint64_t{1} << (cell & 63);
            const bool edges = field == Field::kEdge;
            // a vertex voxel has edges, but no one that is its own
            if (!edges || (chunk->vertices[word] & bit) == 0) {
              pieces_[count++] = {voxel, &details_->Of(*chunk, cell)};
            }
            if (!edges || (chunk->forked[word] & bit) == 0) continue;
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
  return List<1, -1>(voxel_V, field);
}

std::span<const SurfaceWindow::Piece> SurfaceWindow::Round(const GridIndex& voxel_V,
                                                           Field field) noexcept {
  return List<2, 1>(voxel_V, field);
}

}  // namespace tandem
