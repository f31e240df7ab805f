#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collab/lab/case/prediction.h"
#include "collab/lab/run/case_run.h"
#include "collab/lab/sweep/sweep_file.h"

namespace tandem {

/// The outcome of a cell that was run.
struct CellOutcome {
  CaseResult result;
  std::optional<Prediction> predicted;
  double wall_s = 0;
  double cpu_s = 0;
};

using CellRunner = std::function<CellOutcome(const SweepCell&)>;
using CellSink = std::function<void(const SweepCell&, const CellOutcome&)>;

/// Runs the cells on `jobs` threads, the costliest first, so that no long cell remains at the end.
/// Calls `done` once for each cell, in any order, by one thread at a time. The number of threads
/// does not change the outcomes.
void RunCells(std::span<const SweepCell> cells, unsigned jobs, const CellRunner& run,
              const CellSink& done);

}  // namespace tandem
