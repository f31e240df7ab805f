#pragma once

#include <cstdint>
#include <vector>

#include "collab/lab/sweep/sweep_file.h"

namespace tandem {

/// Returns the case of that seed on one line, as `tandem stability run` reads it. The seed alone
/// draws all of it:
///
/// - 2 to 8 users; one hand for all or one each;
/// - hands of 0.1 to 5 kg, 0.3 to 20 N s/m and 0 to 3000 N/m, at the body's centre or up to 0.1 m
///   beside it;
/// - one of the lab's own scenes and of its motions;
/// - a delay of up to 1.2 s one way, sometimes unequal in the two ways;
/// - 10 to 1000 states a second; jitter, loss, and bursts that take up to half of all samples.
///
/// The law is the default one.
std::string RandomCase(std::uint64_t seed);

/// Returns the cells of the seeds first, first + 1, ... Their numbers are their places, from 0.
std::vector<SweepCell> RandomCells(std::uint64_t first, std::size_t count);

}  // namespace tandem
