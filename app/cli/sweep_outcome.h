#pragma once

#include <filesystem>
#include <string>

#include "collab/lab/sweep_summary.h"

namespace tandem {

/// How a sweep was run.
struct SweepRun {
  double wall_s = 0;
  unsigned jobs = 1;
  bool json = false;
};

/// Prints what a sweep comes to, on stdout: the rows and the first cells that fail one, or one JSON
/// object. Gives the exit code.
int TellOutcome(const Results& results, const SweepRun& run);

/// summary.json beside the results file.
std::optional<Error> WriteSummary(const std::filesystem::path& results_file, const Results& results,
                                  const SweepRun& run);

/// Which build this is: 16 hexadecimal digits of the program's file.
std::string ProgramDigest();

}  // namespace tandem
