#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collab/lab/case/lab_scene.h"
#include "collab/lab/sweep/sweep_run.h"

namespace tandem {

/// Bounds that the default law must keep in any drawn case.
inline constexpr double kMostRandomEnergy = 1e-3;  // J, energy that the links give
inline constexpr double kMostRandomTail = 0.5e-3;  // m/s, RMS over all users in the last tenth

/// Runs a drawn case until it is at rest, but no longer than its slowest mode needs to decay. That
/// is ten times the mode's time constant after the last input, at most five minutes. The time is
/// rounded up to whole lengths of the case: max(12 s, 40 delays). In contact the modes of free
/// space count.
CellOutcome RunRandomCase(const LabCase& test, const LabScene& scene);

/// Returns the tail RMS of the case when its links have neither stiffness nor damping, m/s. Hands
/// and contact alone make this motion. If the tail RMS with the links is no greater, the links do
/// not drive the motion.
double TailWithoutLinks(const LabCase& test, const LabScene& scene);

/// A case that was run, and the bounds that it breaks.
struct RandomRecord {
  std::uint64_t seed = 0;
  std::string case_json;
  CellOutcome outcome;
  std::vector<std::string> reasons;  // empty: it passes
};

struct RandomSummary {
  std::size_t cells = 0;
  std::size_t failing = 0;
  std::size_t not_stable = 0;
  std::size_t predicted_stable = 0;
  std::size_t predicted_stable_measured_unstable = 0;
  double max_energy_mJ = 0;
  double max_tail_rms_mm_s = 0;
  double simulated_s = 0;
  double cpu_s = 0;
  std::string digest;               // hash of all cells in the order of their seeds
  std::vector<RandomRecord> worst;  // failing cases, the most reasons and the largest tail first
};

/// Collects drawn cases in any order.
class RandomJudge {
 public:
  explicit RandomJudge(std::uint64_t first) : first_(first) {}
  void See(const SweepCell& cell, const CellOutcome& outcome);
  RandomSummary Finish() const;

 private:
  std::uint64_t first_;
  std::vector<RandomRecord> records_;
};

}  // namespace tandem
