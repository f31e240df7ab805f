#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/study/study.h"

namespace tandem {

/// A number of a stream that these words draw: the same on every machine.
std::uint64_t DrawOf(std::uint64_t seed, const std::string& what, std::uint64_t first,
                     std::uint64_t second = 0);

/// The rows of a Williams design for so many treatments, numbered from 0. In its rows together
/// every treatment stands equally often at each place, and follows each of the others equally
/// often. An even number has as many rows as treatments, an odd one twice as many, one treatment a
/// single row. E. J. Williams, Australian Journal of Scientific Research A 2 (1949) 149-168.
std::vector<std::vector<std::size_t>> WilliamsRows(std::size_t treatments);

/// One trial of a participant, as the study's seed plans it.
struct PlannedTrial {
  int number = 1;  // from 1 on, through all blocks: all that a participant is told
  std::size_t block = 0;
  std::size_t condition = 0;
  int repetition = 1;
  int place = 1;  // in its repetition
};

/// The trials of a participant, counted from 0, in their order.
std::vector<PlannedTrial> TrialsOf(const Study& study, int participant);

/// The name of a trial's folder, within its participant's: trial-007.
std::string TrialFolder(int number);

/// The pseudonyms of all participants, such as P07: different ones, drawn by the seed.
std::vector<std::string> PseudonymsOf(const Study& study);

}  // namespace tandem
