#pragma once

#include <memory>

#include "engine/base/result.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/map/page_source.h"

namespace tandem {

/// Makes a source that computes pages from bits each time they are read, for use where no file can
/// be kept. A page takes about a millisecond, and the bits a tenth of the marks' memory. Errors are
/// those of Voxelize().
Result<std::shared_ptr<const PageSource>> ComputePages(const TriangleMesh& mesh_W,
                                                       const VoxelizeOptions& options);

}  // namespace tandem
