#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/block_file.h"
#include "engine/base/hash.h"
#include "engine/voxel/page_source.h"
#include "engine/voxel/voxmap_image.h"

/// The parts of a kept voxmap's file, which kept_voxmap.h draws.
namespace tandem::kept_voxmap {

inline constexpr std::array<char, 8> kMagic{'t', 'a', 'n', 'd', 'e', 'm', 'K', 'V'};

/// Where a record's page is, and which planes and quarters of the whole map are its own.
struct PageEntry {
  std::uint64_t offset = 0;  // in the file
  std::uint64_t checksum = 0;
  std::uint32_t record = 0;
  std::uint32_t first_bytes = 0;  // of the first piece, compressed
  std::uint32_t known_bytes = 0;  // of the second one
  std::uint32_t first_plane = 0;
  std::uint32_t plane_count = 0;
  std::uint32_t first_quarter = 0;  // of those that are new
  std::uint32_t new_quarters = 0;
  std::uint32_t known_quarters = 0;  // of pages before it
};
static_assert(sizeof(PageEntry) == 48);

/// What the outline keeps of a record.
struct RecordOutline {
  std::array<std::uint64_t, 8> solid{};
  std::array<std::uint8_t, kChunksPerHyperchunk / 2> chunk_marks{};
};
static_assert(sizeof(RecordOutline) == 320);

/// Ends a file: what it is, of what it was made, where its parts are.
struct Tail {
  VoxmapHeader map;  // of the whole map
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t unused = 0;
  MadeOf made_of;
  std::uint64_t pages = 0;  // how many
  std::uint64_t outline_offset = 0;
  std::uint64_t index_bytes = 0;     // compressed; the entries follow it, then the records
  std::uint64_t entries_bytes = 0;   // compressed
  std::uint64_t records_bytes = 0;   // compressed
  std::uint64_t surface_voxels = 0;  // VoxelCounts
  std::uint64_t interior_voxels = 0;
  std::uint64_t free_voxels = 0;
  std::uint64_t outline_checksum = 0;
  std::uint64_t checksum = 0;  // of all of the tail before it
};
static_assert(sizeof(Tail) == 240);

inline std::uint64_t ChecksumOf(const Tail& tail) {
  Hash64 hash;
  hash.AddBytes(&tail, offsetof(Tail, checksum));
  return hash.value();
}

/// The first piece of a page, before it is compressed: stored chunks; planes, by numbers of its
/// own; the numbers of known quarters in the whole map; new quarters.
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
