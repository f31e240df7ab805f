#pragma once

#include <vector>

#include "engine/voxel/surface_voxels.h"
#include "engine/voxel/voxel.h"

namespace tandem {

/// Writes the marks of one hyperchunk's 64^3 voxels (x fastest): 2 on the surface, 2 + d at
/// chess-board distance d <= range from it, 0 beyond (paper §3.1). `place` is in hyperchunks from
/// W's origin.
///
/// A cube of bits grows by one voxel in all directions per step; what a step adds is one farther.
void FillDistances(const SurfaceVoxels& surface, const GridIndex& place, int range,
                   std::vector<Mark>& marks);

}  // namespace tandem
