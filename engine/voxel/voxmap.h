#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/voxel/voxel.h"

namespace tandem {

/// Counts of what a voxmap stores.
struct VoxelCounts {
  std::size_t interior = 0;  // stored ones: those that share a chunk with the surface or its band
  std::size_t surface = 0;
  std::size_t free = 0;  // within range of the surface
  std::size_t chunks = 0;
  std::size_t hyperchunks = 0;
  std::size_t bytes = 0;
  std::size_t total() const { return interior + surface + free; }
};

/// The distance field of a body or fixture, read-only once built (paper §2.1, §3). Frame V: axes of
/// W at the time of voxelization, origin at the lowest corner of the lowest hyperchunk, which is a
/// whole multiple of the voxel size from W's origin; so parts voxelized in one scene have congruent
/// grids.
///
///   hyperchunk table (dense over the box)  ->  512 chunk numbers  ->  512 marks of 4 bits, 256
///   bytes
///
/// Hyperchunk 0 and chunk 0 are "all beyond", hyperchunk 1 and chunk 1 "all interior"; every absent
/// part points to one of them, so that reading has no branch for absence.
class Voxmap {
 public:
  using Chunk = std::array<std::uint8_t, kVoxelsPerChunk / 2>;
  using ChunkTable = std::array<std::uint32_t, kChunksPerHyperchunk>;
  static constexpr std::uint32_t kAllBeyond = 0;
  static constexpr std::uint32_t kAllInterior = 1;

  Voxmap() = default;
  /// An empty map of `size` hyperchunks whose lowest voxel is `origin` (a multiple of 64 in each
  /// axis).
  Voxmap(double voxel_size, int range, GridIndex origin, GridIndex size);

  double voxel_size() const noexcept { return voxel_size_; }
  int range() const noexcept { return range_; }
  /// What is read where nothing was written: one voxel past the range (paper §3.1).
  int beyond() const noexcept { return range_ + 3; }
  /// V's origin in W at the time of voxelization, m.
  Vec3 p_WVo() const noexcept { return voxel_size_ * Vec3(origin_.x, origin_.y, origin_.z); }
  GridIndex origin() const noexcept { return origin_; }
  /// The box of the whole map in V, m; everything outside is beyond.
  Vec3 extent() const noexcept;

  /// The mark of a voxel counted from V's origin, `beyond()` outside.
  int Value(const GridIndex& voxel_V) const noexcept {
    const auto x = static_cast<std::uint32_t>(voxel_V.x);
    const auto y = static_cast<std::uint32_t>(voxel_V.y);
    const auto z = static_cast<std::uint32_t>(voxel_V.z);
    if (x >= limit_[0] || y >= limit_[1] || z >= limit_[2]) return beyond();
    const std::size_t hyperchunk =
        (x >> 6) + size_[0] * ((y >> 6) + std::size_t{size_[1]} * (z >> 6));
    const ChunkTable& chunks = tables_[hyperchunks_[hyperchunk]];
    const Chunk& chunk = chunks_[chunks[CellInBlock(voxel_V >> 3)]];
    const std::size_t cell = CellInBlock(voxel_V);
    const int stored = chunk[cell >> 1] >> ((cell & 1) * 4) & 15;
    return stored != 0 ? stored : beyond();
  }

  VoxelCounts Count() const;
  /// A hash of (place in W, marks) that does not depend on the layout: chunks in Morton order of
  /// their place.
  std::uint64_t Digest() const;

  /// Building, hyperchunk by hyperchunk (place counted from the map's lowest).
  void SetUniform(const GridIndex& hyperchunk, std::uint32_t all_beyond_or_interior);
  /// `marks` holds 64^3 marks, x fastest; `uniform[c]` says which chunks c are all beyond or all
  /// interior (else kStored).
  static constexpr std::uint32_t kStored = 2;
  void SetHyperchunk(const GridIndex& hyperchunk, const std::vector<Mark>& marks,
                     const ChunkTable& uniform);

 private:
  std::size_t TableSlot(const GridIndex& hyperchunk) const;

  double voxel_size_ = 0;
  int range_ = kDefaultRange;
  GridIndex origin_;
  std::array<std::uint32_t, 3> size_{};   // hyperchunks
  std::array<std::uint32_t, 3> limit_{};  // voxels
  std::vector<std::uint32_t> hyperchunks_;
  std::vector<ChunkTable> tables_;
  std::vector<Chunk> chunks_;
};

}  // namespace tandem
