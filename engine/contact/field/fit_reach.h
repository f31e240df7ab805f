#pragma once

#include <span>

#include "engine/contact/pair/contact_model.h"

namespace tandem {

/// The least distance from the surface to which a tight fit reduces the reach, voxels.
inline constexpr double kLeastReach = 0.02;

/// Returns the reach of the next frame, voxels: nearer where contacts push from opposite sides, and
/// slowly farther off again, up to `full_reach`, where they do not.
double FittedReach(std::span<const Contact> contacts, double voxel_size, double reach,
                   double full_reach) noexcept;

}  // namespace tandem
