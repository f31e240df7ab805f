#pragma once

#include <string>
#include <vector>

#include "collab/lab/results_file.h"

namespace tandem {

/// A cell whose course in time is worth a look, and why.
struct ChosenCell {
  std::size_t number = 0;
  std::string why;
};

/// What is not as predicted or expected; of the default law the worst tail, the
/// most energy, the farthest apart; the controls; one of each scene; the nearest to the
/// boundary on either side. At most
/// `most`, the first of these first.
std::vector<ChosenCell> ChooseCells(const Results& results, std::size_t most);

}  // namespace tandem
