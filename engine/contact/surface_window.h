#pragma once

#include <array>
#include <span>

#include "engine/voxel/surface_details.h"
#include "engine/voxel/voxel_surface.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

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
