#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "engine/base/spatial.h"

namespace tandem {

/// The value of a voxel in a field, in 2, 4 or 8 bits (paper §3): 1 interior, 2 surface, 2 + d free
/// space at chess-board distance d >= 1 from the nearest surface voxel. A stored 0 means never
/// written: beyond the range D, it reads as D + 3.
using Mark = std::uint8_t;
inline constexpr Mark kInteriorMark = 1;
inline constexpr Mark kSurfaceMark = 2;

/// The voxels from which a field measures distance (paper §4). Vertex voxels are among the edge
/// voxels, and edge voxels are among the surface voxels. So a surface voxel with a feature vertex
/// is all three.
enum class Field : std::uint8_t { kSurface = 0, kEdge = 1, kVertex = 2 };
inline constexpr std::size_t kFields = 3;
inline constexpr std::array<Field, kFields> kAllFields{Field::kSurface, Field::kEdge,
                                                       Field::kVertex};

/// The label of a voxel, or of a point made from one: the rarest feature in it (paper §4).
enum class Label : std::uint8_t { kSurface = 0, kEdge = 1, kVertex = 2 };

/// Returns the field that a label reads. This is geometrical awareness (paper §4): a vertex meets
/// surfaces, an edge meets edges, a surface meets vertices.
constexpr Field FieldReadBy(Label label) {
  return static_cast<Field>(2 - static_cast<int>(label));
}

/// Chess-board range of the distance field: one chunk, so that a body in a neighbouring chunk is
/// announced.
inline constexpr int kDefaultRange = 8;
/// Returns the widest range that marks of 2, 4 or 8 bits hold. The last value of a byte is the
/// value beyond the range, so that a mark fits into one everywhere.
constexpr int WidestRange(int bits) {
  return bits == 2 ? 1 : (bits == 4 ? 13 : 252);
}
/// Returns the least bits that hold a range.
constexpr int BitsFor(int range) {
  return range <= WidestRange(2) ? 2 : (range <= WidestRange(4) ? 4 : 8);
}

/// The tree's three levels: voxel, chunk of 8 x 8 x 8, hyperchunk of 8 x 8 x 8 chunks (paper §2.1).
inline constexpr int kChunkSide = 8;
inline constexpr int kHyperchunkSide = 64;
inline constexpr std::size_t kVoxelsPerChunk = 512;
inline constexpr std::size_t kChunksPerHyperchunk = 512;

/// A place in a grid of voxels, chunks or hyperchunks. Voxel i covers [i, i+1) voxel sizes from W's
/// origin.
struct GridIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  bool operator==(const GridIndex&) const = default;
  GridIndex operator+(const GridIndex& o) const { return {x + o.x, y + o.y, z + o.z}; }
  GridIndex operator-(const GridIndex& o) const { return {x - o.x, y - o.y, z - o.z}; }
  GridIndex operator*(std::int32_t k) const { return {x * k, y * k, z * k}; }
  /// Returns the place of the chunk, hyperchunk, … that this place lies in: division that rounds
  /// down.
  GridIndex operator>>(int bits) const { return {x >> bits, y >> bits, z >> bits}; }
};

/// Returns the number of a place within a cube of 8 x 8 x 8, x fastest.
inline std::size_t CellInBlock(const GridIndex& i) {
  return static_cast<std::size_t>((i.x & 7) | (i.y & 7) << 3 | (i.z & 7) << 6);
}
inline GridIndex BlockCell(std::size_t cell) {
  const auto c = static_cast<std::int32_t>(cell);
  return {c & 7, c >> 3 & 7, c >> 6};
}

/// A chunk's marks are stored by quarters of 8 x 4 x 4 voxels, a cache line each at 4 bits a mark.
inline constexpr std::size_t kQuarters = 4;
inline constexpr std::size_t kVoxelsPerQuarter = kVoxelsPerChunk / kQuarters;
/// Returns the quarter of a place as of CellInBlock, by the upper halves of y and z.
constexpr std::size_t QuarterOf(std::size_t cell) {
  return (cell >> 5 & 1) | (cell >> 7 & 2);
}
/// Returns the number of the place within its quarter: x, the lower two bits of y, those of z.
constexpr std::size_t CellInQuarter(std::size_t cell) {
  return (cell & 0x1f) | (cell >> 1 & 0x60);
}

/// Interleaves the bits of an index (offset so that it may be negative): nearby cells get nearby
/// codes.
inline std::uint64_t MortonCode(const GridIndex& index) {
  const auto spread = [](std::int32_t value) {
    std::uint64_t v = static_cast<std::uint64_t>(value + (1 << 20)) & 0x1fffffU;
    v = (v | v << 32U) & 0x1f00000000ffffULL;
    v = (v | v << 16U) & 0x1f0000ff0000ffULL;
    v = (v | v << 8U) & 0x100f00f00f00f00fULL;
    v = (v | v << 4U) & 0x10c30c30c30c30c3ULL;
    return (v | v << 2U) & 0x1249249249249249ULL;
  };
  return spread(index.x) | spread(index.y) << 1U | spread(index.z) << 2U;
}

}  // namespace tandem
