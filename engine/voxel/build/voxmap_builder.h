#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voxel/build/surface_bricks.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// Writes the image of a voxmap: its records and planes as they come, its index and the chunk-level
/// field at the end.
class VoxmapBuilder {
 public:
  /// The kind of a hyperchunk, known before it is filled.
  enum class Kind : std::uint8_t { kFar, kMarked, kSolid };

  /// `bits` of a mark: 2 (range 1), 4 (to 13) or 8 (to 252). `kinds` are by cell of the box, whose
  /// border of one hyperchunk is far.
  VoxmapBuilder(double voxel_size, int range, int bits, const HyperchunkBox& box,
                const std::vector<Kind>& kinds);

  /// Adds a marked hyperchunk. The record numbers its planes from the first; `planes` holds four
  /// quarters for each.
  void Add(const GridIndex& place, const VoxmapRecord& record,
           std::span<const std::uint8_t> planes);
  /// Finishes the map. `band_voxels`: of the whole map.
  Voxmap Finish(std::uint64_t band_voxels);
  /// Finishes a map to which no planes were added: every chunk reads as a chunk without a plane.
  Voxmap FinishOutline(std::uint64_t band_voxels);

 private:
  /// Makes the image with room for so many records and for the planes of so many marked
  /// hyperchunks.
  void LayOut(double voxel_size, int range, int bits, std::size_t records, std::size_t marked);
  /// Adds the records, planes and quarters that every map has.
  void AddFirstEntries(int bits);
  void FillChunkLevel();
  Voxmap Written(std::uint64_t band_voxels);
  std::uint32_t NumberOf(const std::uint8_t* quarter, std::uint64_t hash);
  void Widen();

  VoxmapHeader header_;
  HyperchunkBox box_;
  ImageBytes image_;  // begins with the greatest size; the unused rest is freed at the end
  std::uint32_t* index_ = nullptr;
  VoxmapRecord* records_ = nullptr;
  std::uint8_t* quarters_ = nullptr;
  std::size_t quarter_bytes_ = 0;
  std::vector<VoxmapPlane> planes_;
  std::vector<std::uint64_t> hashes_;  // scratch
  /// Hash table of quarters' numbers: the upper half of an entry is that of the hash, 0 is free.
  /// Its size is a power of 2.
  std::vector<std::uint64_t> number_at_;
};

}  // namespace tandem
