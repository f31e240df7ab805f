#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/bits.h"
#include "engine/voxel/map/voxel.h"
#include "engine/voxel/map/voxmap_image.h"

namespace tandem {

/// Counts of what a voxmap stores.
struct VoxelCounts {
  /// Stored interior voxels: those that share a chunk with the surface or its band.
  std::size_t interior = 0;
  std::size_t surface = 0;
  std::size_t edge = 0;    // surface voxels with a feature edge
  std::size_t vertex = 0;  // edge voxels with a feature vertex
  std::size_t free = 0;    // free voxels within range of the surface
  /// Voxels within range of the surface on either side, and the surface itself.
  std::size_t band = 0;
  std::size_t surface_chunks = 0;  // chunks that hold surface voxels
  std::size_t planes = 0;
  std::size_t quarters = 0;  // different quarters
  std::size_t hyperchunks = 0;
  std::size_t bytes = 0;
  std::size_t total() const { return interior + surface + free; }
};

/// The distance fields of a body or fixture, read-only once built (paper §2.1, §3, §4, §5.1). Frame
/// V has the axes of W at the time of voxelization. Its origin is the lowest corner of the box, a
/// whole number of hyperchunks from W's origin; so parts voxelized in one scene have congruent
/// grids. The box has a border of one hyperchunk all round without voxels, so that the chunk-level
/// field reaches its range of eight chunks everywhere.
///
/// All data lie in one image, which voxmap_image.h draws.
class Voxmap {
 public:
  Voxmap() = default;
  explicit Voxmap(ImageBytes image);
  /// Takes a whole image within a larger one, on a cache line.
  explicit Voxmap(ImageBlock block);

  bool empty() const noexcept { return image_ == nullptr; }
  double voxel_size() const noexcept { return header().voxel_size; }
  int range() const noexcept { return static_cast<int>(header().range); }
  int bits() const noexcept { return static_cast<int>(header().bits); }
  /// Returns the value of voxels that were never written: one voxel past the range (paper §3.1).
  int beyond() const noexcept { return range() + 3; }
  GridIndex origin() const noexcept {
    return {header().origin[0], header().origin[1], header().origin[2]};
  }
  /// Returns V's origin in W at the time of voxelization, m.
  Vec3 p_WVo() const noexcept {
    return voxel_size() * Vec3(header().origin[0], header().origin[1], header().origin[2]);
  }
  /// Returns the size of the whole map's box in V, m; everything outside is beyond.
  Vec3 extent() const noexcept;

  /// Returns the mark of a voxel counted from V's origin, `beyond()` outside.
  int Value(Field field, const GridIndex& voxel_V) const noexcept {
    if (!Holds(voxel_V)) return beyond();
    const std::uint32_t plane = PlaneOf(field, voxel_V >> 3);
    const int stored = StoredMark(plane, CellInBlock(voxel_V));
    return stored != 0 ? stored : beyond();
  }

  /// Returns the chunk-level mark of a chunk counted from V's origin: 2 where it holds any mark, 2
  /// + d at a chess-board distance of d chunks from one that does, kChunkBeyond farther off and
  /// outside.
  static constexpr int kChunkRange = 8;
  static constexpr int kChunkBeyond = kChunkRange + 3;
  int ChunkValue(const GridIndex& chunk_V) const noexcept {
    if (!Holds(chunk_V * kChunkSide)) return kChunkBeyond;
    const std::size_t cell = CellInBlock(chunk_V);
    const VoxmapRecord& record = records()[index()[IndexOf(chunk_V >> 3)]];
    const int stored = record.chunk_marks[cell >> 1] >> ((cell & 1) * 4) & 15;
    return stored != 0 ? stored : kChunkBeyond;
  }

  /// The parts of the image, for kernels.
  const VoxmapHeader& header() const noexcept { return *header_; }
  const std::uint32_t* index() const noexcept {
    return reinterpret_cast<const std::uint32_t*>(bytes() + header_->index_offset);
  }
  const VoxmapRecord* records() const noexcept {
    return reinterpret_cast<const VoxmapRecord*>(bytes() + header_->records_offset);
  }
  const VoxmapPlane* planes() const noexcept {
    return reinterpret_cast<const VoxmapPlane*>(bytes() + header_->planes_offset);
  }
  const std::uint8_t* quarters() const noexcept {
    return reinterpret_cast<const std::uint8_t*>(bytes() + header_->quarters_offset);
  }
  std::size_t quarter_bytes() const noexcept { return kVoxelsPerQuarter / 8 * header().bits; }
  /// Returns the plane of a chunk within the box in a field.
  std::uint32_t PlaneOf(Field field, const GridIndex& chunk_V) const noexcept {
    const VoxmapRecord& record = records()[index()[IndexOf(chunk_V >> 3)]];
    const std::size_t cell = CellInBlock(chunk_V);
    const VoxmapSlice& slice = record.slices[static_cast<std::size_t>(field)][cell >> 6];
    const std::uint64_t bit = std::uint64_t{1} << (cell & 63);
    if ((slice.stored & bit) != 0) {
      return slice.first_plane + CountBits(slice.stored & (bit - 1));
    }
    const bool solid = field == Field::kSurface && (record.solid[cell >> 6] & bit) != 0;
    return solid ? kPlaneInterior : kPlaneBeyond;
  }
  /// Returns a mark as it is stored: 0 for beyond.
  int StoredMark(std::uint32_t plane, std::size_t cell) const noexcept {
    const std::size_t bit = CellInQuarter(cell) * header().bits;
    const std::uint32_t quarter = planes()[plane].quarters[QuarterOf(cell)];
    const std::uint8_t byte = quarters()[quarter * quarter_bytes() + (bit >> 3)];
    return byte >> (bit & 7) & ((1 << header().bits) - 1);
  }

  VoxelCounts Count() const;
  /// Returns a hash of (place in W, marks) that does not depend on the layout: chunks in Morton
  /// order of their place.
  std::uint64_t Digest() const;

 private:
  bool Holds(const GridIndex& voxel_V) const noexcept {
    const auto& size = header().size;
    return static_cast<std::uint32_t>(voxel_V.x) < size[0] * kHyperchunkSide &&
           static_cast<std::uint32_t>(voxel_V.y) < size[1] * kHyperchunkSide &&
           static_cast<std::uint32_t>(voxel_V.z) < size[2] * kHyperchunkSide;
  }
  /// Returns the index into index() of a hyperchunk counted from V's origin.
  std::size_t IndexOf(const GridIndex& hyperchunk) const noexcept {
    const auto& size = header().size;
    return static_cast<std::size_t>(hyperchunk.x) +
           size[0] * (static_cast<std::size_t>(hyperchunk.y) +
                      std::size_t{size[1]} * static_cast<std::size_t>(hyperchunk.z));
  }

  const std::byte* bytes() const noexcept { return reinterpret_cast<const std::byte*>(header_); }

  static constexpr VoxmapHeader kNone{};
  std::shared_ptr<const ImageBytes> image_;  // copies of a map share it
  const VoxmapHeader* header_ = &kNone;
};

}  // namespace tandem
