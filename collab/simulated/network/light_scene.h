#pragma once

#include <memory>

#include "collab/simulated/network/box_gap.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Makes the session simulator's scene in code, cheap to simulate. It has a fixed plate, a box that
/// several users may hold (object 1) and two that one user may hold (objects 2 and 3). The boxes
/// measure 40 mm, the voxels 2 mm. At first all stand clear of one another.
std::shared_ptr<const WorldModel> MakeLightScene();

/// Returns the fixed plate.
SolidBox LightScenePlate();

inline constexpr double kLightSceneBox = 0.04;  // m, edge of the moving bodies
inline constexpr int kLightSceneShared = 1;
inline constexpr int kLightSceneFirstOwn = 2;
inline constexpr int kLightSceneObjects = 4;

}  // namespace tandem
