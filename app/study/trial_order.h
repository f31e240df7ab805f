#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/study/study.h"

namespace tandem {

/// Returns a number drawn by its arguments, the same on every machine.
std::uint64_t DrawOf(std::uint64_t seed, const std::string& what, std::uint64_t first,
                     std::uint64_t second = 0);

/// Returns the rows of a Williams design for that many treatments, numbered from 0. Over all rows,
/// each treatment stands equally often at each place, and follows each other treatment equally
/// often. An even number gives as many rows as treatments, an odd one twice as many, one treatment
/// a single row. E. J. Williams, Australian Journal of Scientific Research A 2 (1949) 149-168.
std::vector<std::vector<std::size_t>> WilliamsRows(std::size_t treatments);

/// A trial of a participant, as the study's seed plans it.
struct PlannedTrial {
  int number = 1;  // number from 1 through all blocks; the participant is told no more
  std::size_t block = 0;
  std::size_t condition = 0;
  int repetition = 1;
  int place = 1;  // place in its repetition, from 1
};

/// Returns the trials of a participant in their order. Participants are counted from 0.
std::vector<PlannedTrial> TrialsOf(const Study& study, int participant);

/// Returns the name of a trial's folder within its participant's, such as trial-007.
std::string TrialFolder(int number);

/// Returns the pseudonyms of all participants, such as P07, all different and drawn by the seed.
std::vector<std::string> PseudonymsOf(const Study& study);

}  // namespace tandem
