#pragma once

#include <vector>

#include "engine/field/build/face_distance.h"
#include "engine/geometry/mesh/mesh_facing.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// Finds the faces from which a field measures distance: the boundary of the union of a mesh's
/// bodies, and open sheets that enclose nothing. A face of one body inside another is left out.
/// Where bodies cross, faces are cut along one another.
///
/// The solid is as for the voxelizer: where closed bodies go round a place more often outward than
/// inward, or open ones have a winding number above kInside. `origin` is that of V, voxels.
std::vector<FieldFace> FindFieldFaces(const TriangleMesh& mesh_W, const MeshFacing& facing,
                                      double voxel_size, const GridIndex& origin);

}  // namespace tandem
