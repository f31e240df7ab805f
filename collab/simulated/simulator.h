#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "collab/simulated/fault_schedule.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What became of one seed.
struct SeedResult {
  std::uint64_t seed = 0;
  std::vector<std::string> broken;  // invariants that did not hold; none is as it should be
  std::uint64_t digest = 0;         // of all bodies at all peers, every frame
  double peer_seconds = 0;          // simulated, all peers together
  double seconds = 0;               // simulated, of the session
  Tally tally;                      // of what happened
};

/// Gets a line for everything that happens.
using SeedLog = std::function<void(const std::string&)>;

/// Runs the session that a seed stands for: whole peers, one thread, virtual time. The same seed
/// gives the same bits (of the same build of the program). `model`: of the light scene. `hostile`:
/// with a member that keeps to no rule (HostileMember), until the faults end.
SeedResult SimulateSeed(std::uint64_t seed, const std::shared_ptr<const WorldModel>& model,
                        const SeedLog& log = {}, bool hostile = false);

/// What `simulate` makes of the seeds first, first + 1, … in that order, `threads` at a time, each
/// on one. However many: the same results.
std::vector<SeedResult> RunSeeds(std::uint64_t first, std::uint64_t count, unsigned threads,
                                 const std::function<SeedResult(std::uint64_t)>& simulate);

/// That of SimulateSeed().
std::vector<SeedResult> SimulateSeeds(std::uint64_t first, std::uint64_t count, unsigned threads,
                                      const std::shared_ptr<const WorldModel>& model,
                                      const SeedLog& log = {}, bool hostile = false);

}  // namespace tandem
