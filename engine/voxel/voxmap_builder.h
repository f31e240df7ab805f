#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voxel/surface_bricks.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// Writes the image of a voxmap: its records and planes as they come, its index and the chunk-level
/// field at the end.
class VoxmapBuilder {
 public:
  /// What is known of a hyperchunk before it is filled.
  enum class Kind : std::uint8_t { kFar, kMarked, kSolid };

  /// `bits` of a mark: 2 (range 1), 4 (to 13) or 8 (to 252). `kinds` by cell of the box, whose
  /// border of one hyperchunk is far.
  VoxmapBuilder(double voxel_size, int range, int bits, const HyperchunkBox& box,
                const std::vector<Kind>& kinds);

  /// Of a marked hyperchunk; its planes are numbered from its first one, and lie there as four
  /// quarters each.
  void Add(const GridIndex& place, const VoxmapRecord& record,
           std::span<const std::uint8_t> planes);
  /// `band_voxels` of the whole map.
  Voxmap Finish(std::uint64_t band_voxels);
  /// The same without planes, where none were added: every chunk reads as one without.
  Voxmap FinishOutline(std::uint64_t band_voxels);

 private:
  void FillChunkLevel();
  Voxmap Written(std::uint64_t band_voxels);
  std::uint32_t NumberOf(const std::uint8_t* quarter, std::uint64_t hash);
  void Widen();

  VoxmapHeader header_;
  HyperchunkBox box_;
  ImageBytes image_;  // of the greatest size it may need; given back at the end
  std::uint32_t* index_ = nullptr;
  VoxmapRecord* records_ = nullptr;
  std::uint8_t* quarters_ = nullptr;
  std::size_t quarter_bytes_ = 0;
  std::vector<VoxmapPlane> planes_;
  std::vector<std::uint64_t> hashes_;  // scratch
  /// Numbers of quarters by their hash, whose upper half stands above; 0 for none. Its size is a
  /// power of 2.
  std::vector<std::uint64_t> number_at_;
};

}  // namespace tandem
