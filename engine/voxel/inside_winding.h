#pragma once

#include <cstdint>

#include "engine/geometry/winding_number.h"
#include "engine/voxel/surface_bricks.h"

namespace tandem {

/// Adds to `rows` (kBrickRows of them) the voxels of a hyperchunk, other than surface voxels, whose
/// centres an open surface goes round: its winding number there is above kInside.
///
/// Voxels of a chunk that hang together without surface between them share one evaluation as long
/// as it is clear; where it is not (in a wide hole) each has its own.
void AddWoundVoxels(const WindingNumber& winding, const Bounds& box_W, double voxel_size,
                    const GridIndex& hyperchunk, const SurfaceBricks::Source* surface,
                    std::uint64_t* rows);

/// Above one half, so that next to a flat sheet, where it comes close to that, rounding decides
/// nothing.
inline constexpr double kInside = 0.55;

}  // namespace tandem
