#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/world/world_model.h"

namespace tandem {

/// A body of the scene, fixed or moving, and the distance of its surface.
struct NearestBody {
  std::string name;
  double distance = 0;  // m; 0 where the surfaces cross
};

/// Returns the body whose surface is nearest to that of a moving body, in exact geometry.
/// `bodies_WB`: poses of all moving bodies. Nothing: no body is nearer than `at_most` (m).
std::optional<NearestBody> NearestTo(const WorldModel& model, std::size_t body,
                                     const std::vector<Pose>& bodies_WB, double at_most);

}  // namespace tandem
