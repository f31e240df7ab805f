#include "engine/contact/block_test.h"

#include <algorithm>

namespace tandem {

VoxelTransform::VoxelTransform(const Pose& X_VS, double voxel_size, double shift)
    : displacement(static_cast<float>(shift)) {
  const Mat3 R = X_VS.q.toRotationMatrix() / voxel_size;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      a[static_cast<std::size_t>(3 * row + col)] = static_cast<float>(R(row, col));
    }
    b[static_cast<std::size_t>(row)] = static_cast<float>(X_VS.p[row] / voxel_size);
  }
}

std::array<float, 3> VoxelTransform::operator()(const PointBlocks& blocks, std::size_t block,
                                                std::size_t lane) const noexcept {
  const PointBlocks::Lanes& p = blocks.positions()[block];
  float x = p.x[lane];
  float y = p.y[lane];
  float z = p.z[lane];
  if (displacement != 0) {
    const PointBlocks::Lanes& n = blocks.normals()[block];
    x = x + displacement * n.x[lane];
    y = y + displacement * n.y[lane];
    z = z + displacement * n.z[lane];
  }
  return {((a[0] * x + a[1] * y) + a[2] * z) + b[0], ((a[3] * x + a[4] * y) + a[5] * z) + b[1],
          ((a[6] * x + a[7] * y) + a[8] * z) + b[2]};
}

void TestBlocks(const PointBlocks& blocks, const VoxelTransform& transform, const Voxmap& voxmap,
                int threshold, std::span<const std::uint32_t> list,
                BlockReading* readings) noexcept {
  for (const std::uint32_t b : list) {
    const Field field = blocks.fields()[b];
    BlockReading reading{0, 255};
    for (std::size_t lane = 0; lane < blocks.block(b).count; ++lane) {
      const int mark = voxmap.Value(field, VoxelAt(transform(blocks, b, lane)));
      reading.nearest = std::min(reading.nearest, static_cast<std::uint8_t>(std::min(mark, 255)));
      if (mark <= threshold)
        reading.contacts = static_cast<std::uint16_t>(reading.contacts | 1U << lane);
    }
    *readings++ = reading;
  }
}

}  // namespace tandem
