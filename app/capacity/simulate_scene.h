#pragma once

#include <nlohmann/json.hpp>

#include "engine/base/result.h"

namespace tandem {

/// Runs one session of a scene in virtual time, on one thread. It has a peer for each of the
/// scene's hands, 20 ms apart one way. It ends when the longest hand script or `most_seconds` have
/// ended. Returns how much faster than wall-clock time it goes, by processor time: in all, and in
/// the frames in which every peer's contacts push.
///
///   {scene, peers, simulated_s, cpu_s, speed, contact_s, contact_cpu_s, contact_speed,
///    contact_points, loaded_points}    means over peers, in those frames
///
/// Errors: the scene or a hand script cannot be read, no hand is given, or a hand's body is fixed.
Result<nlohmann::ordered_json> SimulateScene(const std::string& scene, double most_seconds);

}  // namespace tandem
