#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The index of an instance in a world and in its StepInputs. An instance is one body in one place.
/// Each moving body has a first instance, whose index is the body's own. A shared body has a second
/// one, because its holders may have moved it to two places at once (paper §6.1, mixed types).
using InstanceIndex = std::size_t;
/// Stands for the fixture where a pair names its instances.
inline constexpr InstanceIndex kFixture = std::numeric_limits<InstanceIndex>::max();

/// Returns the instances that a world of the model has, each as the index of its body: the first
/// instances of all bodies, then the second ones of shared bodies. A body that moves alone in its
/// scene has no second one, because it meets nothing that moves.
std::vector<std::size_t> InstanceShapes(const WorldModel& model);

/// Returns inputs of the right size for a world of the model: first instances are parked, second
/// ones are inactive, and the hand holds nothing.
StepInputs ParkedInputs(const WorldModel& model);

}  // namespace tandem
