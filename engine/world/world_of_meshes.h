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

/// What LoadWorld() makes of a scene, from meshes: with the default force layer, and without
/// friction, inward shift and polygons of its own. Each mesh must be closed; an error says what is
/// wrong with it. `voxel_size` in metres.
Result<std::shared_ptr<const WorldModel>> WorldOfMeshes(const std::vector<MeshBody>& bodies,
                                                        double voxel_size, ContactModel contact);

}  // namespace tandem
