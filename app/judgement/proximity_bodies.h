#pragma once

#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/proximity/scene_proximity.h"
#include "engine/scene/scene.h"

namespace tandem {

/// Loads the meshes of a scene's bodies, where they stand at first. An error names the body and its
/// file. `remarks`, unless null, get those of ImportMesh(), a line each that names them too.
Result<std::vector<ProximityBody>> LoadProximityBodies(const Scene& scene,
                                                       std::vector<std::string>* remarks = nullptr);

}  // namespace tandem
