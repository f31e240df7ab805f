#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/files/image_bytes.h"
#include "engine/voxel/map/voxel.h"

/// The bytes of a voxmap: one block that means the same wherever it lies, so that it can be mapped
/// from a file (paper §2.1). Offsets are in bytes from its start.
///
///   header   | what the numbers below mean, where each part begins
///   index    | uint32 per hyperchunk of the box, x fastest: its record
///   records  | per hyperchunk near the surface: which chunks store a plane, and where
///   quarters | 128 marks of 2, 4 or 8 bits each, all different (docs/decisions/0007)
///   planes   | per (chunk, field) with marks of more than one kind: its four quarters
///
/// A plane's number is found without a table: the slice's first plane plus the stored chunks below
/// its own bit.
namespace tandem {

inline constexpr std::uint32_t kVoxmapVersion = 2;

struct VoxmapHeader {
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t bits = 0;   // bits of a mark
  std::uint32_t range = 0;  // D, voxels
  std::uint32_t reserved = 0;
  double voxel_size = 0;                 // m
  std::array<std::int32_t, 3> origin{};  // lowest voxel of the box, from W's origin
  std::array<std::uint32_t, 3> size{};   // hyperchunks
  std::uint64_t index_offset = 0;
  std::uint64_t records_offset = 0;
  std::uint64_t record_count = 0;
  std::uint64_t planes_offset = 0;
  std::uint64_t plane_count = 0;
  std::uint64_t bytes = 0;  // size of the whole image
  /// Voxels within the range of a surface voxel on either side, and surface voxels.
  std::uint64_t band_voxels = 0;
  std::uint64_t quarters_offset = 0;
  std::uint64_t quarter_count = 0;
};
static_assert(sizeof(VoxmapHeader) == 128);

/// The 8 x 8 chunks of one z in a hyperchunk, in one field.
struct VoxmapSlice {
  std::uint64_t stored = 0;  // bit x + 8 y: the chunk has a plane
  /// First plane of this slice; the others follow in the order of their bits.
  std::uint32_t first_plane = 0;
  std::uint32_t reserved = 0;
};
static_assert(sizeof(VoxmapSlice) == 16);

struct alignas(64) VoxmapRecord {
  std::array<std::array<VoxmapSlice, 8>, kFields> slices{};
  /// Chunks without a plane in the surface field: 1 interior, 0 beyond.
  std::array<std::uint64_t, 8> solid{};
  /// The chunk-level field (paper §5.1): 4-bit marks in units of chunks, 2 for a chunk that holds
  /// any mark, 2 + d at d chunks from one that does.
  std::array<std::uint8_t, kChunksPerHyperchunk / 2> chunk_marks{};
};
static_assert(sizeof(VoxmapRecord) == 704);

/// The marks of a chunk in a field: numbers of quarters, by QuarterOf().
struct alignas(16) VoxmapPlane {
  std::array<std::uint32_t, kQuarters> quarters{};
};
static_assert(sizeof(VoxmapPlane) == 16);

inline constexpr std::uint32_t kRecordFar = 0;    // nothing near: beyond in every field and level
inline constexpr std::uint32_t kRecordSolid = 1;  // inside throughout
inline constexpr std::uint32_t kPlaneBeyond = 0;
inline constexpr std::uint32_t kPlaneInterior = 1;
inline constexpr std::uint32_t kQuarterBeyond = 0;
inline constexpr std::uint32_t kQuarterInterior = 1;

}  // namespace tandem
