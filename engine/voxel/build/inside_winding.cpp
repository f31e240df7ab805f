#include "engine/voxel/build/inside_winding.h"

#include <array>
#include <bit>
#include <cmath>

namespace tandem {

namespace {

constexpr double kClear = 0.3;               // distance from kInside
using Cells = std::array<std::uint64_t, 8>;  // cells of a chunk, in the order of CellInBlock

constexpr std::uint64_t kLowestX = 0x0101010101010101U;

/// Returns the cells that are connected with the seed within `free`.
Cells Flood(const Cells& free, const Cells& seed) {
  Cells flooded = seed;
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t z = 0; z < 8; ++z) {
      const std::uint64_t w = flooded[z];
      std::uint64_t wide =
          w | (w & ~(kLowestX << 7U)) << 1U | (w & ~kLowestX) >> 1U | w << 8U | w >> 8U;
      if (z > 0) wide |= flooded[z - 1];
      if (z < 7) wide |= flooded[z + 1];
      wide &= free[z];
      grows = grows || wide != w;
      flooded[z] = wide;
    }
  }
  return flooded;
}

std::size_t FirstOf(const Cells& cells) {
  std::size_t word = 0;
  while (cells[word] == 0) ++word;
  return 64 * word + static_cast<std::size_t>(std::countr_zero(cells[word]));
}

/// Returns the cells of a chunk that are no surface voxels.
Cells FreeCells(const GridIndex& chunk, const SurfaceBricks::Source* surface) {
  Cells free;
  free.fill(~std::uint64_t{0});
  if (surface != nullptr && !surface->empty()) {
    for (std::size_t z = 0; z < 8; ++z) {
      std::uint64_t taken = 0;
      const std::uint64_t* octet = surface->Octet(static_cast<std::size_t>(chunk.z) * 8 + z,
                                                  static_cast<std::size_t>(chunk.y));
      for (std::size_t y = 0; y < 8 && octet != nullptr; ++y) {
        taken |= (octet[y] >> (8 * chunk.x) & 0xffU) << (8 * y);
      }
      free[z] = ~taken;
    }
  }
  return free;
}

/// Returns the free cells of a chunk that are inside. One place decides for cells that are
/// connected, where its winding number is clear.
template <typename CentreOf>
Cells InsideOf(const WindingNumber& winding, const Cells& free, const CentreOf& centre_of) {
  Cells all;
  all.fill(~std::uint64_t{0});
  const bool whole = free == all;
  Cells inside{};
  for (Cells left = free; left != Cells{};) {
    Cells seed{};
    const std::size_t at = whole ? CellInBlock({4, 4, 4}) : FirstOf(left);
    seed[at >> 6U] = std::uint64_t{1} << (at & 63U);
    const Cells together = whole ? free : Flood(free, seed);
    const double number = winding.At(centre_of(at));
    const bool clear = std::abs(number - kInside) > kClear;
    for (std::size_t word = 0; word < 8; ++word) {
      left[word] &= ~together[word];
      if (clear) {
        if (number > kInside) inside[word] |= together[word];
        continue;
      }
      for (std::uint64_t rest = together[word]; rest != 0; rest &= rest - 1) {
        const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
        if (winding.At(centre_of(64 * word + bit)) > kInside) {
          inside[word] |= std::uint64_t{1} << bit;
        }
      }
    }
  }
  return inside;
}

}  // namespace

void AddWindingVoxels(const WindingNumber& winding, const Bounds& box_W, double voxel_size,
                      const GridIndex& hyperchunk, const SurfaceBricks::Source* surface,
                      std::uint64_t* rows) {
  for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
    const GridIndex chunk = BlockCell(c);
    const GridIndex first = hyperchunk * kHyperchunkSide + chunk * kChunkSide;
    const auto centre_of = [&](std::size_t cell) {
      const GridIndex i = first + BlockCell(cell);
      return Vec3(voxel_size * Vec3(i.x + 0.5, i.y + 0.5, i.z + 0.5));
    };
    Bounds box;
    box.Add(centre_of(0));
    box.Add(centre_of(kVoxelsPerChunk - 1));
    if (!box.Overlaps(box_W)) continue;
    const auto row_of = [&](std::size_t y, std::size_t z) {
      return static_cast<std::size_t>(chunk.y) * 8 + y +
             kHyperchunkSide * (static_cast<std::size_t>(chunk.z) * 8 + z);
    };
    const Cells free = FreeCells(chunk, surface);
    const Cells inside = InsideOf(winding, free, centre_of);
    for (std::size_t z = 0; z < 8; ++z) {
      for (std::size_t y = 0; y < 8; ++y) {
        rows[row_of(y, z)] |= (inside[z] >> (8 * y) & 0xffU) << (8 * chunk.x);
      }
    }
  }
}

}  // namespace tandem
