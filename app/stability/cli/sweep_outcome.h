#pragma once

#include <filesystem>
#include <string>

#include "collab/lab/sweep/sweep_summary.h"

namespace tandem {

/// The way in which a sweep was run.
struct SweepRun {
  double wall_s = 0;
  unsigned jobs = 1;
  bool json = false;
};

/// Prints the outcome of a sweep on stdout: the rows and the first cells that fail one, or one JSON
/// object. Returns the exit code.
int TellOutcome(const Results& results, const SweepRun& run);

/// Writes summary.json beside the results file.
std::optional<Error> WriteSummary(const std::filesystem::path& results_file, const Results& results,
                                  const SweepRun& run);

/// Returns which build this is: 16 hexadecimal digits of the program's file.
std::string ProgramDigest();

}  // namespace tandem
