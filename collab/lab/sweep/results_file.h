#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collab/lab/sweep/sweep_run.h"

namespace tandem {

/// The first line of a results file. It says which sweep the cells come from.
struct ResultsHeader {
  std::string sweep;  // name of the sweep
  std::uint64_t seed = 1;
  std::string sweep_hash;
  std::string version;    // version of the program
  std::string program;    // build of that version
  std::size_t cells = 0;  // number of cells of the whole sweep
  std::string shard = "1/1";
  std::string command;  // command line that runs all of it

  bool operator==(const ResultsHeader&) const = default;
};

/// A cell that was run, as a line of a results file has it.
struct CellRecord {
  SweepCell cell;  // cell without its cost and rank
  CellOutcome outcome;
};

/// Returns {"sweep", "seed", "sweep_hash", "version", "program", "cells", "shard", "command"} on
/// one line.
std::string LineOf(const ResultsHeader& header);

/// Returns {"cell", "key", "case": {...}, "verdict", "predicted": {"stable", "stiffness",
/// "critical", "covers"} or null, "expect": "stable", "unstable" or null, "metrics": {...},
/// "digest", "simulated_s", "wall_s", "cpu_s", "fault": null or why it could not be run} on one
/// line. Numbers have enough digits to be read back bit for bit; infinities and NaN become null.
std::string LineOf(const CellRecord& record);

/// A results file in memory: a header and cells in the order of their numbers.
struct Results {
  ResultsHeader header;
  std::map<std::size_t, CellRecord> records;
};

/// Reads a results file. It passes over an incomplete last line, which a killed program leaves.
/// Errors name the file and the line.
Result<Results> ReadResults(const std::filesystem::path& file);

/// Writes the results in the order of the cells to a file beside it, which then replaces it.
std::optional<Error> WriteResults(const std::filesystem::path& file, const Results& results);

/// Merges the results of all shards. The result equals one run of the whole sweep, but for the
/// times that the cells took. Errors name files that do not belong together, or cells that are
/// missing.
Result<Results> Merge(const std::vector<std::filesystem::path>& files);

/// Records cells as they are done, so that a killed run can go on where it was.
class ResultsLog {
 public:
  /// Opens the file. If it exists, the log continues it; then its header must be the same but for
  /// the command.
  static Result<ResultsLog> Open(const std::filesystem::path& file, const ResultsHeader& header);

  /// Returns all cells, those read from the file included.
  const Results& results() const { return results_; }
  bool Has(const SweepCell& cell) const { return results_.records.contains(cell.number); }

  /// Writes a line; the system has it when this returns.
  std::optional<Error> Add(const CellRecord& record);
  /// Closes the log and rewrites the file in the order of the cells.
  std::optional<Error> Finish();

 private:
  ResultsLog() = default;

  std::filesystem::path file_;
  Results results_;
  std::ofstream out_;
};

/// Returns a hash of the cells' digests, in the order of their numbers.
std::string DigestOf(const Results& results);

}  // namespace tandem
