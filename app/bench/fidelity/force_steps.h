#pragma once

#include <functional>
#include <memory>

#include "engine/contact/pair/body_pair.h"
#include "engine/world/world.h"

namespace tandem {

/// Makes a pair of the first body of a world and its fixture. No frame has tested the pair.
std::unique_ptr<BodyPair> FixturePair(const WorldModel& model);

/// Returns the contact force on the pair's first body at rest at X_WB, N. It reads every point.
Vec3 ForceAtRest(BodyPair& pair, const Pose& X_WB);

/// Looks for a jump of a force (N) larger than `largest` along a way from 0 to 1. It cuts the way
/// into `parts`, halves each part and keeps the half with the larger difference. It stops when
/// almost nothing is left of the part, or its difference is no larger. Returns the larger of that
/// jump and `largest`.
double LargestForceStep(const std::function<Vec3(double)>& force_at, int parts, double largest);

}  // namespace tandem
