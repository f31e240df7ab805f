#include "engine/contact/surface_window.h"

namespace tandem {

template <bool hole>
std::span<const SurfaceWindow::Piece> SurfaceWindow::List(const GridIndex& voxel_V,
                                                          const GridIndex& low,
                                                          const GridIndex& high,
                                                          Field field) noexcept {
  std::size_t count = 0;
  const auto add = [&](const SurfaceDetails::Chunk& chunk, std::size_t cell,
                       const GridIndex& voxel) {
    // a vertex voxel has edges, but no one that is its own
    if (field != Field::kEdge || !SurfaceDetails::Has(chunk.vertices, cell)) {
      pieces_[count++] = {voxel, &details_->Of(chunk, cell)};
    }
    if (field == Field::kVertex || !SurfaceDetails::Has(chunk.forked, cell)) return;
    for (const SurfaceDetails::MoreEdge& edge : details_->MoreEdges(chunk, cell)) {
      pieces_[count++] = {voxel, &edge.detail, edge.ends};
    }
  };
  VisitSources<hole>(*voxmap_, *details_, low, high, voxel_V, field, add);
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
