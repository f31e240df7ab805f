#pragma once

#include <array>
#include <cstdint>

#include "engine/voxel/map/voxel.h"

namespace tandem {

/// A mesh's vertices in units of 2^-20 voxel sizes, whole numbers. All decisions on voxels are
/// computed from these without rounding. So they are exact for the snapped mesh (which is within
/// half a millionth of a voxel of the given mesh) and the same on every machine. |coordinate| <
/// 2^51.
inline constexpr int kSnapBits = 20;
using SnappedPoint = std::array<std::int64_t, 3>;
using SnappedTriangle = std::array<SnappedPoint, 3>;

SnappedPoint Snap(const Vec3& p_W, double voxel_size);

}  // namespace tandem
