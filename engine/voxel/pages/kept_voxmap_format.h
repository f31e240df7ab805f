#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/files/block_file.h"
#include "engine/base/hash.h"
#include "engine/voxel/map/page_source.h"
#include "engine/voxel/map/voxmap_image.h"

/// The parts of a kept voxmap's file, which kept_voxmap.h draws.
namespace tandem::kept_voxmap {

inline constexpr std::array<char, 8> kMagic{'t', 'a', 'n', 'd', 'e', 'm', 'K', 'V'};

/// The place of a record's page, and the planes and quarters of the whole map that are its own.
struct PageEntry {
  std::uint64_t offset = 0;  // offset in the file
  std::uint64_t checksum = 0;
  std::uint32_t record = 0;
  std::uint32_t first_bytes = 0;  // size of the first piece, compressed
  std::uint32_t known_bytes = 0;  // size of the second piece, compressed
  std::uint32_t first_plane = 0;
  std::uint32_t plane_count = 0;
  std::uint32_t first_quarter = 0;  // first of the new quarters
  std::uint32_t new_quarters = 0;
  std::uint32_t known_quarters = 0;  // quarters of pages before it
};
static_assert(sizeof(PageEntry) == 48);

/// The part of a record that the outline keeps.
struct RecordOutline {
  std::array<std::uint64_t, 8> solid{};
  std::array<std::uint8_t, kChunksPerHyperchunk / 2> chunk_marks{};
};
static_assert(sizeof(RecordOutline) == 320);

/// The end of a file: its kind, its sources, the places of its parts.
struct Tail {
  VoxmapHeader map;  // header of the whole map
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t unused = 0;
  BlockFileSources made_of;
  std::uint64_t pages = 0;  // number of pages
  std::uint64_t outline_offset = 0;
  std::uint64_t index_bytes = 0;     // compressed; the entries follow it, then the records
  std::uint64_t entries_bytes = 0;   // compressed
  std::uint64_t records_bytes = 0;   // compressed
  std::uint64_t surface_voxels = 0;  // VoxelCounts
  std::uint64_t interior_voxels = 0;
  std::uint64_t free_voxels = 0;
  std::uint64_t outline_checksum = 0;
  std::uint64_t checksum = 0;  // checksum of all of the tail before it
};
static_assert(sizeof(Tail) == 288);

inline std::uint64_t ChecksumOf(const Tail& tail) {
  Hash64 hash;
  hash.AddBytes(&tail, offsetof(Tail, checksum));
  return hash.value();
}

/// The layout of the first piece of a page, before compression: stored chunks; planes, in the
/// page's own numbers; the numbers of known quarters in the whole map; new quarters.
class FirstPiece {
 public:
  FirstPiece(const PageEntry& entry, std::size_t quarter_bytes)
      : planes_(kFields * 8 * sizeof(std::uint64_t)),
        numbers_(planes_ + entry.plane_count * sizeof(VoxelPage::planes[0])),
        quarters_(numbers_ + entry.known_quarters * sizeof(std::uint32_t)),
        bytes_(quarters_ + entry.new_quarters * quarter_bytes) {}
  std::size_t planes() const noexcept { return planes_; }
  std::size_t numbers() const noexcept { return numbers_; }
  std::size_t quarters() const noexcept { return quarters_; }
  std::size_t bytes() const noexcept { return bytes_; }

 private:
  std::size_t planes_;
  std::size_t numbers_;
  std::size_t quarters_;
  std::size_t bytes_;
};

}  // namespace tandem::kept_voxmap
