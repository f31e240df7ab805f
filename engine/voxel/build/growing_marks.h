#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/voxel/build/mark_packing.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// A hyperchunk and the voxels round it as a cube of bits, which grows from the sources, and the
/// digits of the marks that it leaves in the hyperchunk. MarkPlanes says how.
struct GrowingMarks {
  static constexpr int kHalo = 16;
  static constexpr int kSide = kHyperchunkSide + 2 * kHalo;
  /// Rows of a layer: kSide of them, the first at kFirstRow, so that vectors may read beyond them.
  static constexpr int kStride = kSide + 16;
  static constexpr int kFirstRow = 8;
  /// Two words a row: voxels -16..47 and 16..79 from the hyperchunk's lowest. Growth from beyond a
  /// word's ends is missed; after 16 steps the error has not reached voxels 0..31 and 32..63.
  struct alignas(64) Layer {
    std::array<std::array<std::uint64_t, kStride>, 2> words{};
  };

  std::array<Layer, kSide> cube{};
  std::array<Layer, 3> ring{};                // layers grown along x and y
  std::array<std::uint16_t, kSide> octets{};  // per layer: eights of rows that have bits
  std::array<std::uint16_t, 3> ring_octets{};
  /// Per layer: eights of rows that have bits at the end.
  std::array<std::uint16_t, kSide> touched{};
  MarkDigits digits;
  std::uint64_t marked = 0;  // number of voxels with a mark
};

/// Grows the cube of sources, which are `base` voxels from those of the field, by `range` voxels,
/// and writes the digits of the new voxels.
void GrowMarks(GrowingMarks& marks, int base, int range);

/// Counts the voxels of the hyperchunk that have a mark.
void CountMarks(GrowingMarks& marks);

}  // namespace tandem
