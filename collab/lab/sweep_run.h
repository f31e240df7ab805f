#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collab/lab/case_run.h"
#include "collab/lab/prediction.h"
#include "collab/lab/sweep_file.h"

namespace tandem {

/// A cell that was run.
struct CellOutcome {
  CaseResult result;
  std::optional<Prediction> predicted;
  double wall_s = 0;
  double cpu_s = 0;
};

using CellRunner = std::function<CellOutcome(const SweepCell&)>;
using CellSink = std::function<void(const SweepCell&, const CellOutcome&)>;

/// Runs the cells on so many threads, the costly ones first, so that none of them is left over for
/// the end. `done` is called once for each, in whatever order, by one thread at a time. How many
/// threads there are does not bear on what comes out.
void RunCells(std::span<const SweepCell> cells, unsigned jobs, const CellRunner& run,
              const CellSink& done);

}  // namespace tandem
