#pragma once

#include "engine/dynamics/axis_radii.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Measures the mesh of a body of the refined contact model. Other bodies have one radius for all
/// axes: the travel of their points is counted from the centre.
AxisRadii AxisRadiiOf(const WorldModel& model, std::size_t body);

}  // namespace tandem
