#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "collab/simulated/simulator.h"

namespace tandem {

/// Runs the session of hands that a seed stands for, in virtual time. Two or three controllers are
/// on a simulated network, at most one of them with a device process and a person's hand. Each has
/// hosts that drag, grab, go back, stop, crash and compete. Controllers are killed, stopped and
/// replaced. The same seed and length give the same bits. `seconds` is the length of the session,
/// at least 10. Its events end eight seconds earlier, so that all comes to rest, which may take
/// longer.
SeedResult SimulateHands(std::uint64_t seed, double seconds,
                         const std::shared_ptr<const WorldModel>& model, const SeedLog& log = {});

/// Returns the results for the seeds first, first + 1, … in that order, as SimulateSeeds() does.
std::vector<SeedResult> SimulateHandSeeds(std::uint64_t first, std::uint64_t count,
                                          unsigned threads, double seconds,
                                          const std::shared_ptr<const WorldModel>& model,
                                          const SeedLog& log = {});

}  // namespace tandem
