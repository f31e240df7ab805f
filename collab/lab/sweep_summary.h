#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "collab/lab/results_file.h"

namespace tandem {

/// A claim about the cells, and whether it holds.
struct SweepRow {
  std::string name;
  std::string bar;
  double value = 0;
  bool pass = false;
};

/// What a sweep comes to. A default-law cell has the default law as it is: its own name, limits and
/// ratio 1. A control is a cell that its author holds to be unstable.
struct SweepSummary {
  std::size_t cells = 0;  // that were run
  std::string digest;
  std::size_t predicted_stable = 0;
  std::size_t predicted_stable_measured_unstable = 0;
  std::size_t predicted_stable_undecided = 0;
  std::size_t undecided = 0;  // of all cells
  std::size_t default_law_cells = 0;
  std::size_t default_law_unstable = 0;  // or undecided
  double max_energy_mJ = 0;              // of default-law cells, as all figures of the kind
  double max_tail_rms_mm_s = 0;
  std::size_t positive_controls = 0;
  std::size_t positive_controls_caught = 0;
  double simulated_s = 0;
  double cpu_s = 0;
  double wall_s = 0;           // of all cells, one after the other
  double free_pair_speed = 0;  // simulated s a second of processor time, two users in free space;
                               // 0: no such cells
  std::vector<std::size_t> failing;  // cells that a row fails by
  std::vector<SweepRow> rows;        // only those that there are cells for

  bool pass() const;
};

SweepSummary Summarize(const Results& results);

/// Whether it is a default-law cell.
bool IsOfDefaultLaw(const CellRecord& record);

/// One JSON object, indented.
std::string JsonOf(const SweepSummary& summary, double wall_s, unsigned jobs);

}  // namespace tandem
