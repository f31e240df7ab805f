#pragma once

#include <memory>

#include "collab/simulated/box_gap.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The scene of the session simulator, made in code and cheap to simulate: a fixed plate, a box
/// that several may hold (object 1) and two that one may (objects 2 and 3), of 40 mm, at voxels of
/// 2 mm. All stand clear of one another at first.
std::shared_ptr<const WorldModel> MakeLightScene();

/// The fixed plate.
SolidBox LightScenePlate();

inline constexpr double kLightSceneBox = 0.04;  // m, edge of the moving bodies
inline constexpr int kLightSceneShared = 1;
inline constexpr int kLightSceneFirstOwn = 2;
inline constexpr int kLightSceneObjects = 4;

}  // namespace tandem
