#pragma once

#include <memory>
#include <vector>

#include "engine/world/world_model.h"

namespace tandem {

/// A body of a world that is made in code, without files.
struct MeshBody {
  TriangleMesh mesh_W;  // in its first pose
  bool fixed = false;
  double mass = 0.3;  // kg, for a moving body
};

/// Makes from meshes what LoadWorld() makes from a scene with the default force layer. Meshes of
/// moving bodies must be closed. `voxel_size` is in metres. An error says what cannot be voxelized.
Result<std::shared_ptr<const WorldModel>> WorldOfMeshes(
    const std::vector<MeshBody>& bodies, double voxel_size, ContactModel contact,
    double clearance_range_voxels = kDefaultClearanceRange);

}  // namespace tandem
