#include "engine/voxel/build/snapped_point.h"

#include <cmath>

namespace tandem {

SnappedPoint Snap(const Vec3& p_W, double voxel_size) {
  SnappedPoint snapped{};
  for (int k = 0; k < 3; ++k) {
    snapped[static_cast<std::size_t>(k)] =
        std::llround(p_W[k] / voxel_size * static_cast<double>(1 << kSnapBits));
  }
  return snapped;
}

}  // namespace tandem
