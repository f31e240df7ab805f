#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "engine/contact/schedule/point_blocks.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// Takes points to voxels: p in voxels of V = a p + b + d n. The order in single precision is
/// always ((a0 x + a1 y) + a2 z) + b, so that every processor finds the same voxel.
struct VoxelTransform {
  std::array<float, 9> a{};  // row by row; R_VS / voxel size
  std::array<float, 3> b{};  // p_VS / voxel size
  float displacement = 0;    // m, along the inward normals

  VoxelTransform() = default;
  VoxelTransform(const Pose& X_VS, double voxel_size, double displacement);

  /// Returns where a point of the shell is, in voxels of V.
  std::array<float, 3> operator()(const PointBlocks& blocks, std::size_t block,
                                  std::size_t lane) const noexcept;
};

/// Returns the voxel that a place in voxels lies in, or a voxel beyond all maps if no integer holds
/// it.
inline GridIndex VoxelAt(const std::array<float, 3>& p) noexcept {
  const auto down = [](float x) {
    constexpr float kBeyond = 1 << 30;
    // false for NaN
    const float held = x >= -kBeyond ? std::min(x, kBeyond) : -kBeyond;
    const auto i = static_cast<std::int32_t>(held);
    return i - (held < static_cast<float>(i) ? 1 : 0);
  };
  return {down(p[0]), down(p[1]), down(p[2])};
}

/// Returns the greatest error of a place from a VoxelTransform, voxels, where coordinates and the
/// shell's reach are up to `voxels`: nine roundings of single precision.
inline double PlaceError(double voxels) noexcept {
  return std::max(0.004, 9.0 * voxels / (1U << 24U));
}

/// The greatest diameter of a block, voxels; far above that of any pointshell, which has a point in
/// every voxel of its own surface.
inline constexpr double kWidestBlock = 8000;

/// The result of testing a block.
struct BlockReading {
  std::uint16_t contacts = 0;  // lanes with a mark <= the threshold
  std::uint8_t nearest = 0;    // least mark of its points, each read in its own field
};

/// Reads the marks of all points of the listed blocks, each in the field that its label reads
/// (paper §4). No mark is above 255 - 3, so a byte holds them. Points outside the map read beyond.
/// The bits are the same on every processor: one source is compiled for each instruction set, and
/// the first call chooses among them (docs/decisions/0009-block-test.md). A block must be less than
/// kWidestBlock across.
void TestBlocks(const PointBlocks& blocks, const VoxelTransform& transform, const Voxmap& voxmap,
                int threshold, std::span<const std::uint32_t> list,
                BlockReading* readings) noexcept;

/// Does the same arithmetic without the look-up, as if each voxel's mark were its number in its
/// chunk. `tandem bench points` compares TestBlocks with it.
void TransformBlocks(const PointBlocks& blocks, const VoxelTransform& transform, int threshold,
                     std::span<const std::uint32_t> list, BlockReading* readings) noexcept;

/// Returns the instruction set that TestBlocks uses on this processor, e.g. "AVX3".
const char* KernelIsa() noexcept;

}  // namespace tandem
