#pragma once

#include <optional>
#include <vector>

#include "app/cli/penetration_oracle.h"
#include "collab/peer.h"
#include "engine/world/world_model.h"

namespace tandem {

/// How far two instances of a body were apart, at equal times of the machine's clock (m).
struct TraceDivergence {
  double peak = 0;
  double last = 0;
};
TraceDivergence DivergenceOf(const std::vector<TraceSample>& a, const std::vector<TraceSample>& b);

/// Whether a body has come to rest: in the last third, RMS speed below 2 mm/s and 2 degrees/s, and
/// not growing from half second to half second, unless it ends below 0.1 mm/s.
bool IsAtRest(const std::vector<TraceSample>& trace);

/// What became of a body in a run.
struct Outcome {
  double travel = 0;  // m, of its centre
  bool out = false;   // its box has left the fixture's
};
Outcome OutcomeOf(const WorldModel& model, std::size_t body, const Pose& X_WB);

/// Judges by exact geometry all poses that are given, a series of each instance, against all that
/// is fixed; or as many as there is time for. `voxel_size`: unit of the depths, and twice the
/// distance of the samples on the body.
PenetrationReport Penetration(const WorldModel& model, std::size_t body,
                              const std::vector<std::vector<Pose>>& series, double voxel_size,
                              double seconds_limit);

/// Judges every tenth pose and every pose with contact force, of all instances.
PenetrationReport Penetration(const WorldModel& model, std::size_t body,
                              const std::vector<std::vector<TraceSample>>& instances,
                              double seconds_limit);

}  // namespace tandem
