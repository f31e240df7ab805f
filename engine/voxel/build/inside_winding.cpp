#include "engine/voxel/build/inside_winding.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <utility>

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

TriangleMesh OpenBodies(const TriangleMesh& mesh_W, const MeshFacing& facing) {
  TriangleMesh open{mesh_W.vertices, {}};
  for (std::size_t t = 0; t < facing.open.size(); ++t) {
    if (facing.open[t] == 0) continue;
    TriangleMesh::Triangle corners = mesh_W.triangles[t];
    if (facing.of_triangle[t] < 0) std::swap(corners[1], corners[2]);
    open.triangles.push_back(corners);
  }
  return open;
}

namespace {

/// The cost of winding numbers, as found at some places.
struct WindingCost {
  double steps = 0;    // average number of one place
  double unclear = 0;  // share of the places where a chunk cannot be decided at once
};

/// Looks at places all over a box, the same ones in each run.
WindingCost CostIn(const WindingNumber& winding, const Bounds& box) {
  constexpr std::size_t kPlaces = 256;
  constexpr std::size_t kMostSteps = 20'000'000;
  // multiples of the powers of the root of x^4 = x + 1 fill a cube evenly, modulo 1
  const Vec3 stride(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
  std::size_t steps = 0;
  std::size_t unclear = 0;
  std::size_t places = 0;
  for (; places < kPlaces && steps < kMostSteps; ++places) {
    Vec3 share = static_cast<double>(places + 1) * stride;
    for (double& x : share) x -= std::floor(x);
    const double number = winding.At(box.min + share.cwiseProduct(box.size()), steps);
    if (std::abs(number - kInside) <= kClear) ++unclear;
  }
  const auto count = static_cast<double>(places);
  return {static_cast<double>(steps) / count, static_cast<double>(unclear) / count};
}

}  // namespace

std::optional<Error> WindingCostFault(const TriangleMesh& mesh_W, const MeshFacing& facing,
                                      double voxel_size, std::size_t places) {
  constexpr double kSteps = 4e8;  // some 16 s of a processor
  // more voxels may cost more: so much takes a voxel where clusters stand for what is far
  constexpr double kStepsOfAChunk = 64.0 * kVoxelsPerChunk;
  constexpr double kSecondsOfAStep = 4e-8;
  const TriangleMesh open = OpenBodies(mesh_W, facing);
  if (open.triangles.empty()) return std::nullopt;
  const Bounds box = BoundsOf(open);
  const WindingCost cost = CostIn(WindingNumber(open), box);
  const auto chunks = [&](double size) {
    return (box.size() / (kChunkSide * size) + Vec3::Ones()).prod();
  };
  const auto steps = [&](double size) {
    const double of_chunk = 1 - cost.unclear + kVoxelsPerChunk * cost.unclear;
    return cost.steps * (chunks(size) * of_chunk + static_cast<double>(places));
  };
  const auto is_too_much = [&](double size) {
    return steps(size) > kSteps + kStepsOfAChunk * chunks(size);
  };
  if (!is_too_much(voxel_size)) return std::nullopt;
  double fits = voxel_size;
  while (is_too_much(fits) && fits < 1e6) fits *= 1.05;
  char text[300];
  const int length = std::snprintf(
      text, sizeof text,
      "%zu triangles are of open bodies, and long ones face all ways: to find what is inside would "
      "take about %.0f s of a processor: close the bodies",
      open.triangles.size(), kSecondsOfAStep * steps(voxel_size));
  if (fits < 1e6) {
    std::snprintf(text + length, sizeof text - static_cast<std::size_t>(length),
                  ", or use voxels of %.2g m", 1.05 * fits);
  }
  return Error{text};
}

}  // namespace tandem
