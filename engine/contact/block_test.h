#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "engine/contact/point_blocks.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// Points to voxels: p in voxels of V = a p + b + d n, in single precision, always in the order
/// ((a0 x + a1 y) + a2 z) + b, so that every processor finds the same voxel.
struct VoxelTransform {
  std::array<float, 9> a{};  // row by row; R_VS / voxel size
  std::array<float, 3> b{};  // p_VS / voxel size
  float displacement = 0;    // m, along the inward normals

  VoxelTransform() = default;
  VoxelTransform(const Pose& X_VS, double voxel_size, double displacement);

  /// Where a point of the shell is, in voxels of V.
  std::array<float, 3> operator()(const PointBlocks& blocks, std::size_t block,
                                  std::size_t lane) const noexcept;
};

/// The voxel a place in voxels lies in; one beyond all maps if no integer holds it.
inline GridIndex VoxelAt(const std::array<float, 3>& p) noexcept {
  const auto down = [](float x) {
    constexpr float kBeyond = 1 << 30;
    // false of what is no number
    const float held = x >= -kBeyond ? std::min(x, kBeyond) : -kBeyond;
    const auto i = static_cast<std::int32_t>(held);
    return i - (held < static_cast<float>(i) ? 1 : 0);
  };
  return {down(p[0]), down(p[1]), down(p[2])};
}

/// Voxels that places of a VoxelTransform may err by where coordinates and the shell's own reach
/// that many voxels: nine roundings of single precision.
inline double PlaceError(double voxels) noexcept {
  return std::max(0.004, 9.0 * voxels / (1U << 24U));
}

/// Voxels. Far more than any pointshell's, which has a point in every voxel of its own surface.
inline constexpr double kWidestBlock = 8000;

/// What the test of a block says.
struct BlockReading {
  std::uint16_t contacts = 0;  // lanes with a mark <= the threshold
  std::uint8_t nearest = 0;    // least mark of its points, each read in its own field
};

/// Reads the marks of all points of the listed blocks, each in the field that its label reads
/// (paper §4). Marks above 255 - 3 do not exist, so a byte holds them. Points outside the map read
/// beyond. The same bits on every processor: one source, compiled for each instruction set and
/// chosen when first called (docs/decisions/0009-block-test.md). A block must be less than
/// kWidestBlock across.
void TestBlocks(const PointBlocks& blocks, const VoxelTransform& transform, const Voxmap& voxmap,
                int threshold, std::span<const std::uint32_t> list,
                BlockReading* readings) noexcept;

/// The same arithmetic and results without the look-up, as if each voxel's mark were its number in
/// its chunk: what `tandem bench points` compares TestBlocks with.
void TransformBlocks(const PointBlocks& blocks, const VoxelTransform& transform, int threshold,
                     std::span<const std::uint32_t> list, BlockReading* readings) noexcept;

/// The instruction set that TestBlocks was chosen for on this processor, e.g. "AVX3".
const char* KernelIsa() noexcept;

}  // namespace tandem
