#pragma once

#include <cstdint>
#include <vector>

#include "collab/lab/sweep_file.h"

namespace tandem {

/// The case of that seed, on one line, as `tandem stability run` reads it. By the seed alone it
/// draws: 2 to 8 users; one hand for all or one each, of 0.1 to 5 kg, 0.3 to 20 N s/m and 0 to
/// 3000 N/m, which holds the body at its centre or up to 0.1 m beside; one of the lab's own scenes
/// and of its motions; 0 to 1.2 s one way, shared unequally by the two ways at times; 10 to 1000
/// states a second; jitter, loss, and bursts that take up to half of all samples. The law is the
/// default one.
std::string RandomCase(std::uint64_t seed);

/// The cells of the seeds first, first + 1, ... Their number is that of their place from 0.
std::vector<SweepCell> RandomCells(std::uint64_t first, std::size_t count);

}  // namespace tandem
