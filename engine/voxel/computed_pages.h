#pragma once

#include <memory>

#include "engine/base/result.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/page_source.h"
#include "engine/voxel/voxelize.h"

namespace tandem {

/// Pages that are computed from bits each time they are read, where no file can be kept: about a
/// millisecond each, and a tenth of the marks' memory. With the errors of Voxelize().
Result<std::shared_ptr<const PageSource>> ComputePages(const TriangleMesh& mesh_W,
                                                       const VoxelizeOptions& options);

}  // namespace tandem
