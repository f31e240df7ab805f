#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "app/judgement/penetration_oracle.h"
#include "collab/peer/peer.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The distance of two instances of a body at equal times of the machine's clock, m.
struct TraceDivergence {
  double peak = 0;
  double last = 0;
};
TraceDivergence DivergenceOf(const std::vector<TraceSample>& a, const std::vector<TraceSample>& b);

/// Returns the least and the most time by which the second hand is behind the first at equal frames
/// of both, s; below 0: before it. Frames that one of the two misses change it.
std::pair<double, double> HandsApart(const std::vector<TraceSample>& a,
                                     const std::vector<TraceSample>& b);

/// Returns whether a body has come to rest. In the last third its RMS speed is below 2 mm/s and 2
/// degrees/s. It does not grow from half second to half second, unless it ends below 0.1 mm/s.
bool IsAtRest(const std::vector<TraceSample>& trace);

/// The outcome of a run for a body.
struct Outcome {
  double travel = 0;  // m, displacement of its centre of mass
  bool out = false;   // its box does not meet the fixture's
};
Outcome OutcomeOf(const WorldModel& model, std::size_t body, const Pose& X_WB);

/// Judges poses by exact geometry against all fixed bodies, a series of poses for each instance. It
/// judges all poses, or as many as the time allows, and bounds the error of the greatest depth.
/// `voxel_size`: unit of the depths, and twice the spacing of the samples on the body.
PenetrationReport Penetration(const WorldModel& model, std::size_t body,
                              const std::vector<std::vector<Pose>>& series, double voxel_size,
                              double seconds_limit);

/// Judges every tenth pose and every pose with contact force, of all instances.
PenetrationReport Penetration(const WorldModel& model, std::size_t body,
                              const std::vector<std::vector<TraceSample>>& instances,
                              double seconds_limit);

}  // namespace tandem
