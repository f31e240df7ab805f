#pragma once

#include <cstdint>

#include "engine/geometry/exact/winding_number.h"
#include "engine/voxel/build/surface_bricks.h"

namespace tandem {

/// Adds to `rows` (kBrickRows of them) the voxels of a hyperchunk, other than surface voxels, whose
/// centres an open surface goes round: its winding number there is above kInside.
///
/// Connected voxels of a chunk without surface between them share one evaluation if it is clear;
/// otherwise (in a wide hole) each has its own.
void AddWindingVoxels(const WindingNumber& winding, const Bounds& box_W, double voxel_size,
                      const GridIndex& hyperchunk, const SurfaceBricks::Source* surface,
                      std::uint64_t* rows);

/// The winding number above which a voxel is inside. It exceeds one half, so that rounding decides
/// nothing next to a flat sheet, where the number is close to that.
inline constexpr double kInside = 0.55;

}  // namespace tandem
