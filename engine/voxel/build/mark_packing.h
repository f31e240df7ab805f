#pragma once

#include <array>
#include <cstdint>

#include "engine/voxel/build/surface_bricks.h"

namespace tandem {

/// The marks of a hyperchunk by binary digit, as rows of bits: y + 64 z.
struct MarkDigits {
  alignas(64) std::array<std::array<std::uint64_t, kBrickRows>, 8> rows;
  /// Per z: the eights of rows that hold digits; the contents of the others are undefined.
  std::array<std::uint8_t, kHyperchunkSide> written{};
  std::size_t count = 4;  // number of digits: 4 or 8
};

/// The digits of eight chunks, by x: up to 8 digits of 8 words each.
using ChunkDigits = std::array<std::array<std::uint64_t, 64>, 8>;

/// Takes the digits of the eight chunks along x at (cy, cz). `inside` and `surface` are rows of the
/// hyperchunk; `solid`: all is inside. Returns bits 0 to 7: the chunk has digits; bits 8 to 15: all
/// of it is inside.
unsigned GatherChunks(const MarkDigits& digits, std::size_t cy, std::size_t cz,
                      const std::uint64_t* inside, const SurfaceBricks::Source* surface, bool solid,
                      ChunkDigits& chunks);

/// Packs the 512 marks of a chunk from their digits (8 words each), quarter after quarter.
void PackMarks(const std::uint64_t* digits, int bits, std::uint8_t* plane);

}  // namespace tandem
