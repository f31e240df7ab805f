#pragma once

#include <nlohmann/json.hpp>

#include "engine/base/result.h"

namespace tandem {

/// One session of a scene in virtual time, on one thread: a peer for each of its hands, 20 ms apart
/// one way, until the longest hand script or `most_seconds` have ended. Gives how much faster than
/// the clock on the wall it goes, by processor time: in all, and in the frames in which every
/// peer's contacts push.
///
///   [scene, peers, simulated_s, cpu_s, speed, contact_s, contact_cpu_s, contact_speed,
///    contact_points, loaded_points]    of a peer in the mean, in those frames
///
/// Error: the scene cannot be read.
Result<nlohmann::ordered_json> SimulateScene(const std::string& scene, double most_seconds);

}  // namespace tandem
