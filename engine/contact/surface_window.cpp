#include "engine/contact/surface_window.h"

namespace tandem {

template <bool hole>
std::span<const SurfaceWindow::Piece> SurfaceWindow::List(const GridIndex& voxel_V,
                                                          const GridIndex& low,
                                                          const GridIndex& high,
                                                          Field field) noexcept {
  std::size_t count = 0;
  VisitPieces<hole>(*voxmap_, *details_, low, high, voxel_V, field,
                    [&](const GridIndex& voxel, const SurfaceDetail& detail, bool ends) {
                      pieces_[count++] = {voxel, &detail, ends};
                    });
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
