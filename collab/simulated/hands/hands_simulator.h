#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "collab/simulated/simulator.h"

namespace tandem {

/// Runs the session of hands that a seed stands for, in virtual time: two or three controllers on a
/// simulated network, each with hosts that drag, grab, go back, stop, crash and compete, one of
/// them perhaps with a device's process and a person's hand; controllers are killed, stopped and
/// replaced. The same seed and length give the same bits. `seconds`: of the session, at least 10;
/// the last eight are for coming to rest.
SeedResult SimulateHands(std::uint64_t seed, double seconds,
                         const std::shared_ptr<const WorldModel>& model, const SeedLog& log = {});

/// Seeds first, first + 1, … in that order, as SimulateSeeds() does.
std::vector<SeedResult> SimulateHandSeeds(std::uint64_t first, std::uint64_t count,
                                          unsigned threads, double seconds,
                                          const std::shared_ptr<const WorldModel>& model,
                                          const SeedLog& log = {});

}  // namespace tandem
