#pragma once

#include <utility>

#include "engine/field/build/field_builder.h"
#include "tests/support/shapes.h"

namespace tandem::testing {

inline constexpr double kVoxelSize = 0.001;
inline constexpr double kReach = 0.45;  // voxels

inline DistanceField BuiltField(const TriangleMesh& mesh) {
  return std::move(*BuildField(mesh, {.voxel_size = kVoxelSize}));
}

inline Vec3 InVoxels(const DistanceField& field, const Vec3& p_W) {
  return (p_W - field.p_WVo()) / kVoxelSize;
}

/// Returns a floor and a wall that stand on one another at a right angle.
inline TriangleMesh Notch() {
  TriangleMesh notch = Box(kVoxelSize * Vec3(40, 40, 10));
  Append(notch, Transformed(Box(kVoxelSize * Vec3(10, 40, 30)),
                            {Quat::Identity(), kVoxelSize * Vec3(-15, 0, 10)}));
  return notch;
}

}  // namespace tandem::testing
