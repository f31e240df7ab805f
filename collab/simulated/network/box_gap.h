#pragma once

#include "engine/base/spatial.h"

namespace tandem {

/// A box about its own origin, along its own axes.
struct SolidBox {
  Pose X_WB;
  Vec3 half = Vec3::Zero();  // m
};

/// Returns the gap between two boxes, m. Where they overlap, it is minus the shortest way out of
/// one another; where they are apart, at most their distance. It tries the fifteen axes that can
/// separate boxes.
double BoxGap(const SolidBox& a, const SolidBox& b);

}  // namespace tandem
