#include "engine/voxel/distance_field.h"

#include <algorithm>
#include <bit>

#include "engine/base/int128.h"

namespace tandem {

namespace {

constexpr int kHalo = 16;  // at least kMaxRange, whole chunks
constexpr int kSide = kHyperchunkSide + 2 * kHalo;
static_assert(kHalo >= kMaxRange && kHalo % kChunkSide == 0 && kSide <= 128);

using Row = Uint128;            // the voxels along x, the halo's first at bit 0
using Cube = std::vector<Row>;  // rows at y + kSide z

std::size_t RowAt(int y, int z) {
  return static_cast<std::size_t>(y + kSide * z);
}

bool FillSurface(const SurfaceVoxels& surface, const GridIndex& place, Cube& cube) {
  bool any = false;
  const int chunks = kSide / kChunkSide;
  const int halo_chunks = kHalo / kChunkSide;
  for (int z = 0; z < chunks; ++z) {
    for (int y = 0; y < chunks; ++y) {
      for (int x = 0; x < chunks; ++x) {
        const GridIndex chunk =
            place * kChunkSide + GridIndex{x - halo_chunks, y - halo_chunks, z - halo_chunks};
        const SurfaceVoxels::Bits* bits = surface.BitsAt(chunk);
        if (bits == nullptr) continue;
        any = true;
        for (int cz = 0; cz < kChunkSide; ++cz) {
          for (int cy = 0; cy < kChunkSide; ++cy) {
            const Row row = (*bits)[static_cast<std::size_t>(cz)] >> (8 * cy) & 0xffU;
            cube[RowAt(kChunkSide * y + cy, kChunkSide * z + cz)] |= row << (kChunkSide * x);
          }
        }
      }
    }
  }
  return any;
}

/// `grown` = `cube` grown by one voxel along y and x, then along z, rows at the rim left out of
/// sight.
void Grow(const Cube& cube, Cube& scratch, Cube& grown) {
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      Row row = cube[RowAt(y, z)];
      if (y > 0) row |= cube[RowAt(y - 1, z)];
      if (y + 1 < kSide) row |= cube[RowAt(y + 1, z)];
      scratch[RowAt(y, z)] = row | row << 1 | row >> 1;
    }
  }
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      Row row = scratch[RowAt(y, z)];
      if (z > 0) row |= scratch[RowAt(y, z - 1)];
      if (z + 1 < kSide) row |= scratch[RowAt(y, z + 1)];
      grown[RowAt(y, z)] = row;
    }
  }
}

void WriteNew(const Cube& before, const Cube& now, Mark mark, std::vector<Mark>& marks) {
  for (int z = 0; z < kHyperchunkSide; ++z) {
    for (int y = 0; y < kHyperchunkSide; ++y) {
      const std::size_t r = RowAt(y + kHalo, z + kHalo);
      auto added = static_cast<std::uint64_t>((now[r] & ~before[r]) >> kHalo);
      Mark* row = &marks[static_cast<std::size_t>(kHyperchunkSide * (y + kHyperchunkSide * z))];
      for (; added != 0; added &= added - 1) row[std::countr_zero(added)] = mark;
    }
  }
}

}  // namespace

void FillDistances(const SurfaceVoxels& surface, const GridIndex& place, int range,
                   std::vector<Mark>& marks) {
  marks.assign(std::size_t{kHyperchunkSide} * kHyperchunkSide * kHyperchunkSide, 0);
  Cube cube(std::size_t{kSide} * kSide, 0);
  if (!FillSurface(surface, place, cube)) return;
  Cube grown(cube.size());
  Cube scratch(cube.size());
  WriteNew(grown, cube, kSurfaceMark, marks);
  for (int distance = 1; distance <= range; ++distance) {
    Grow(cube, scratch, grown);
    WriteNew(cube, grown, static_cast<Mark>(kSurfaceMark + distance), marks);
    std::swap(cube, grown);
  }
}

}  // namespace tandem
