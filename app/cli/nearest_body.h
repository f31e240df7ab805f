#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/world/world_model.h"

namespace tandem {

/// A body of the scene, fixed or moving, and how far its surface is.
struct NearestBody {
  std::string name;
  double distance = 0;  // m; 0 where the surfaces cross
};

/// The body whose surface is nearest to that of a moving body, in exact geometry. `bodies_WB`:
/// where all moving bodies are. Nothing: none is as near as `at_most` (m).
std::optional<NearestBody> NearestTo(const WorldModel& model, std::size_t body,
                                     const std::vector<Pose>& bodies_WB, double at_most);

}  // namespace tandem
