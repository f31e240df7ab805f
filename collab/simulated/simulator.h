#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "collab/simulated/network/fault_schedule.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The result of one seed.
struct SeedResult {
  std::uint64_t seed = 0;
  std::vector<std::string> broken;  // invariants that were violated
  std::uint64_t digest = 0;         // hash of all bodies at all peers, every tenth frame
  double peer_seconds = 0;          // simulated, all peers together
  double seconds = 0;               // simulated length of the session
  Tally tally;                      // counts of events
};

/// Takes a line for each event.
using SeedLog = std::function<void(const std::string&)>;

/// Runs the session that a seed stands for: complete peers, one thread, virtual time. The same seed
/// gives the same bits in the same build of the program. `model` is the light scene's. With
/// `hostile`, a member that keeps to no rule (HostileMember) takes part until the faults end.
SeedResult SimulateSeed(std::uint64_t seed, const std::shared_ptr<const WorldModel>& model,
                        const SeedLog& log = {}, bool hostile = false);

/// Returns the results of `simulate` for the seeds first, first + 1, … in that order. It runs
/// `threads` seeds at a time, each on one thread. The number of threads does not change the
/// results.
std::vector<SeedResult> RunSeeds(std::uint64_t first, std::uint64_t count, unsigned threads,
                                 const std::function<SeedResult(std::uint64_t)>& simulate);

/// Returns the results of SimulateSeed() for these seeds.
std::vector<SeedResult> SimulateSeeds(std::uint64_t first, std::uint64_t count, unsigned threads,
                                      const std::shared_ptr<const WorldModel>& model,
                                      const SeedLog& log = {}, bool hostile = false);

}  // namespace tandem
