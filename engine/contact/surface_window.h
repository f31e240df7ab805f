#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "engine/voxel/surface_details.h"
#include "engine/voxel/voxel_surface.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// The cells of one z of a chunk with x and y in ranges, which may lie partly outside; none that is
/// empty.
inline std::uint64_t CellsWithin(std::int32_t x0, std::int32_t x1, std::int32_t y0,
                                 std::int32_t y1) noexcept {
  constexpr std::int32_t kLast = kChunkSide - 1;
  const int left = std::max(x0, 0);
  const int right = kLast - std::min(x1, kLast);
  const int first = std::max(y0, 0);
  const int last = kLast - std::min(y1, kLast);
  const std::uint64_t row = 0xffU >> (left + right) << left;
  const std::uint64_t rows = ~std::uint64_t{0} >> (8 * (first + last)) << (8 * first);
  return row * 0x0101010101010101U & rows;
}

/// Calls visit(voxel, detail, ends) for the pieces of surface that are sources of a field, from
/// `low` to `high` and chunk by chunk; with a hole, not for those within one voxel of `hole_V`.
/// `ends`: an edge that ends here, which its tangent points away from.
template <bool hole, class Visit>
void VisitPieces(const Voxmap& voxmap, const SurfaceDetails& details, const GridIndex& low,
                 const GridIndex& high, const GridIndex& hole_V, Field field,
                 const Visit& visit) noexcept {
  const auto visit_cell = [&](const SurfaceDetails::Chunk& chunk, std::size_t cell,
                              const GridIndex& voxel) {
    // a vertex voxel has edges, but no one that is its own
    if (field != Field::kEdge || !SurfaceDetails::Has(chunk.vertices, cell)) {
      visit(voxel, details.Of(chunk, cell), false);
    }
    if (field == Field::kVertex || !SurfaceDetails::Has(chunk.forked, cell)) return;
    for (const SurfaceDetails::MoreEdge& edge : details.MoreEdges(chunk, cell)) {
      visit(voxel, edge.detail, edge.ends);
    }
  };
  const auto& size = voxmap.header().size;
  const auto last = [&](std::size_t axis, std::int32_t at) {
    return std::min(at >> 3, static_cast<std::int32_t>(8 * size[axis]) - 1);
  };
  for (std::int32_t cz = std::max(low.z >> 3, 0); cz <= last(2, high.z); ++cz) {
    for (std::int32_t cy = std::max(low.y >> 3, 0); cy <= last(1, high.y); ++cy) {
      for (std::int32_t cx = std::max(low.x >> 3, 0); cx <= last(0, high.x); ++cx) {
        const SurfaceDetails::Chunk* chunk = details.At(voxmap, {cx, cy, cz});
        if (chunk == nullptr) continue;
        const SurfaceVoxels::Bits& sources = chunk->Sources(field);
        const GridIndex first = GridIndex{cx, cy, cz} * kChunkSide;
        const GridIndex from = low - first;
        const GridIndex to = high - first;
        const GridIndex at = hole_V - first;
        const std::uint64_t within = CellsWithin(from.x, to.x, from.y, to.y);
        const bool meets =
            hole && at.x >= -1 && at.x <= kChunkSide && at.y >= -1 && at.y <= kChunkSide;
        const std::uint64_t inner = meets ? CellsWithin(at.x - 1, at.x + 1, at.y - 1, at.y + 1) : 0;
        const std::int32_t z1 = std::min(to.z, kChunkSide - 1);
        for (std::int32_t z = std::max(from.z, 0); z <= z1; ++z) {
          const auto word = static_cast<std::size_t>(z);
          std::uint64_t cells = sources[word] & within;
          if (hole && z >= at.z - 1 && z <= at.z + 1) cells &= ~inner;
          for (; cells != 0; cells &= cells - 1) {
            const std::size_t cell = 64 * word + static_cast<std::size_t>(std::countr_zero(cells));
            visit_cell(*chunk, cell, first + BlockCell(cell));
          }
        }
      }
    }
  }
}

/// The pieces of a map's exact surface about one of its voxels, found chunk by chunk.
///
/// Used by one thread; no call allocates.
class SurfaceWindow {
 public:
  struct Piece {
    GridIndex voxel_V;
    const SurfaceDetail* detail;
    bool ends = false;  // an edge that ends here, which its tangent points away from

    /// Where the piece is, in voxels of V.
    Vec3 place() const noexcept {
      constexpr double kStep = 1.0 / 255.0;
      const auto& at = detail->place;
      return {voxel_V.x + kStep * at[0], voxel_V.y + kStep * at[1], voxel_V.z + kStep * at[2]};
    }
  };

  SurfaceWindow(const Voxmap& voxmap, const SurfaceDetails& details) noexcept
      : voxmap_(&voxmap), details_(&details) {}

  /// The sources of a field within one voxel of a voxel, of edges and surfaces with all edges
  /// there; valid until the next call.
  std::span<const Piece> Near(const GridIndex& voxel_V, Field field) noexcept;
  /// Those beyond one voxel from it and within `below` and `above`, 1 or 2 along each axis.
  std::span<const Piece> Round(const GridIndex& voxel_V, const GridIndex& below,
                               const GridIndex& above, Field field) noexcept;

 private:
  /// From `low` to `high`; with a hole, not what is within one voxel.
  template <bool hole>
  std::span<const Piece> List(const GridIndex& voxel_V, const GridIndex& low, const GridIndex& high,
                              Field field) noexcept;

  const Voxmap* voxmap_;
  const SurfaceDetails* details_;
  std::array<Piece, 98 * (1 + VoxelSurface::kMostMoreEdges)> pieces_;
};

}  // namespace tandem
