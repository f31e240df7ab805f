#pragma once

#include <string>
#include <vector>

#include "collab/lab/sweep/results_file.h"

namespace tandem {

/// A cell whose course in time the report shows, with the reason.
struct ChosenCell {
  std::size_t number = 0;
  std::string why;
};

/// Chooses at most `most` cells of a sweep, the first kinds first:
/// - a few cells expected or predicted stable that are not, and controls that are not unstable
/// - the default law's cells with the worst tail, the most energy, and the farthest apart
/// - a few controls, and a cell of each scene
/// - the cells nearest to the boundary on both sides
std::vector<ChosenCell> ChooseCells(const Results& results, std::size_t most);

}  // namespace tandem
