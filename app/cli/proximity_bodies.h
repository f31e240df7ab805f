#pragma once

#include <vector>

#include "engine/base/result.h"
#include "engine/world/scene.h"
#include "engine/world/scene_proximity.h"

namespace tandem {

/// Loads the meshes of a scene's bodies, where they stand at first. An error names the body and its
/// file.
Result<std::vector<ProximityBody>> LoadProximityBodies(const Scene& scene);

}  // namespace tandem
