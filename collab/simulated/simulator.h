#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/world/world_model.h"

namespace tandem {

/// What became of one seed.
struct SeedResult {
  std::uint64_t seed = 0;
  std::vector<std::string> broken;  // invariants that did not hold; none is as it should be
  std::uint64_t digest = 0;         // of all bodies at all peers, every frame
  double peer_seconds = 0;          // simulated, all peers together
};

/// Runs the session that a seed stands for: whole peers, one thread, virtual time. The same seed
/// gives the same bits (of the same build of the program). `model`: of the light scene.
SeedResult SimulateSeed(std::uint64_t seed, const std::shared_ptr<const WorldModel>& model);

/// What the seed stands for, a line an event.
std::vector<std::string> DescribeSeed(std::uint64_t seed);

}  // namespace tandem
