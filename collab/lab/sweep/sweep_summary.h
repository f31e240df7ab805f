#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "collab/lab/sweep/results_file.h"

namespace tandem {

/// A claim about the cells and whether it holds.
struct SweepRow {
  std::string name;
  std::string bar;
  double value = 0;
  bool pass = false;
};

/// The summary of a sweep. A default-law cell has the unchanged default law: its own name, limits
/// and ratio 1. A control is a cell that its author expects to be unstable.
struct SweepSummary {
  std::size_t cells = 0;  // number of cells that were run
  std::string digest;
  std::size_t predicted_stable = 0;
  std::size_t predicted_stable_measured_unstable = 0;
  std::size_t predicted_stable_undecided = 0;
  std::size_t undecided = 0;  // among all cells
  std::size_t default_law_cells = 0;
  std::size_t default_law_unstable = 0;  // unstable, undecided or not run
  double max_energy_mJ = 0;              // default-law cells only, as the next figure
  double max_tail_rms_mm_s = 0;
  std::size_t positive_controls = 0;
  std::size_t positive_controls_caught = 0;
  double simulated_s = 0;
  double cpu_s = 0;
  double wall_s = 0;           // sum over all cells, as if run one after the other
  double free_pair_speed = 0;  // simulated s per second of processor time, two users in free space;
                               // 0: no such cells
  std::vector<std::size_t> failing;  // cells that make a row fail
  std::vector<SweepRow> rows;        // rows for which there are cells

  bool pass() const;
};

SweepSummary Summarize(const Results& results);

/// Returns whether it is a default-law cell.
bool IsOfDefaultLaw(const CellRecord& record);

/// Returns one indented JSON object.
std::string JsonOf(const SweepSummary& summary, double wall_s, unsigned jobs);

}  // namespace tandem
