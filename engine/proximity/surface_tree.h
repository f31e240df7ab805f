#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/geometry/exact/tree_pair.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// The surface voxels of a map as points at their centres, chunk by chunk in a tree of boxes, for
/// queries of distances beyond the range of the fields. It takes 80 bytes a chunk and the chunk's
/// share of the tree. Read-only once built. All is in the map's W at the time of voxelization.
class SurfaceTree {
 public:
  struct Chunk {
    GridIndex first;                    // its lowest voxel, from W's origin
    std::array<std::uint64_t, 8> bits;  // its surface voxels: slices of z, bit x + 8 y
  };

  SurfaceTree() = default;
  explicit SurfaceTree(const Voxmap& voxmap);

  bool empty() const noexcept { return chunks_.empty(); }
  double voxel_size() const noexcept { return voxel_size_; }
  std::size_t voxel_count() const noexcept { return voxel_count_; }
  /// Returns a tree of boxes round the centres. A leaf is one chunk: its node's `first`.
  const BoxTree& tree() const noexcept { return tree_; }
  const std::vector<Chunk>& chunks() const noexcept { return chunks_; }
  Vec3 CentreOf(const GridIndex& voxel) const noexcept {
    return voxel_size_ * Vec3(voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5);
  }

  /// Calls `visit(p_WC)` for the centres within `reach` of p (m).
  template <typename Visit>
  void VisitWithin(const Vec3& p, double reach, const Visit& visit) const noexcept;

  /// Returns the centre of the surface voxel nearest to p, if one lies within `reach`.
  std::optional<Vec3> Nearest(const Vec3& p, double reach) const noexcept;

 private:
  double voxel_size_ = 0;
  std::size_t voxel_count_ = 0;
  BoxTree tree_;
  std::vector<Chunk> chunks_;
};

/// Calls `visit(cell)` for the set bits, with cells as in CellInBlock().
template <typename Visit>
void VisitCells(const std::array<std::uint64_t, 8>& bits, const Visit& visit) {
  for (std::size_t z = 0; z < 8; ++z) {
    for (std::uint64_t rest = bits[z]; rest != 0; rest &= rest - 1) {
      visit(64 * z + static_cast<std::size_t>(std::countr_zero(rest)));
    }
  }
}

template <typename Visit>
void SurfaceTree::VisitWithin(const Vec3& p, double reach, const Visit& visit) const noexcept {
  const double squared = reach * reach;
  VisitNearLeaves(tree_, p, squared, [&](const BoxTree::Node& leaf) {
    const Chunk& chunk = chunks_[leaf.first];
    VisitCells(chunk.bits, [&](std::size_t cell) {
      const Vec3 centre = CentreOf(chunk.first + BlockCell(cell));
      if ((centre - p).squaredNorm() <= squared) visit(centre);
    });
    return squared;
  });
}

}  // namespace tandem
