#pragma once

#include <functional>
#include <memory>

#include "engine/contact/body_pair.h"
#include "engine/world/world.h"

namespace tandem {

/// The first body of a world and its fixture, as a pair that no frame has tested.
std::unique_ptr<BodyPair> FixturePair(const WorldModel& model);

/// The contact force on the pair's first body at rest at X_WB, N, every point being read.
Vec3 ForceAtRest(BodyPair& pair, const Pose& X_WB);

/// Looks for a larger jump of a force (N) than `largest` between shares of a way, 0 to 1, in so
/// many parts: each is halved, the half with the larger difference kept, until nothing is left of
/// it or its difference is no larger. Gives the larger of both.
double LargestForceStep(const std::function<Vec3(double)>& force_at, int parts, double largest);

}  // namespace tandem
