#pragma once

#include <memory>
#include <vector>

#include "engine/world/world_model.h"

namespace tandem {

/// A body of a world that is made in code, with no files.
struct MeshBody {
  TriangleMesh mesh_W;  // where it stands at first
  bool fixed = false;
  double mass = 0.3;  // kg, of a moving one
};

/// Makes of meshes what LoadWorld() makes of a scene with the default force layer. Those of moving
/// bodies are closed. `voxel_size` in metres. An error says what cannot be voxelized.
Result<std::shared_ptr<const WorldModel>> WorldOfMeshes(
    const std::vector<MeshBody>& bodies, double voxel_size, ContactModel contact,
    double clearance_range_voxels = kDefaultClearanceRange);

}  // namespace tandem
