#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collab/lab/sweep_run.h"

namespace tandem {

/// The first line of a results file: what the cells below it are cells of.
struct ResultsHeader {
  std::string sweep;  // its name
  std::uint64_t seed = 1;
  std::string sweep_hash;
  std::string version;    // of the program
  std::string program;    // which build of that version
  std::size_t cells = 0;  // of the whole sweep
  std::string shard = "1/1";
  std::string command;  // that runs all of it

  bool operator==(const ResultsHeader&) const = default;
};

/// A cell that was run, as it stands in a results file.
struct CellRecord {
  SweepCell cell;  // but for its cost
  CellOutcome outcome;
};

/// {"sweep", "seed", "sweep_hash", "version", "program", "cells", "shard", "command"} on one line.
std::string LineOf(const ResultsHeader& header);

/// {"cell", "key", "case": {...}, "verdict", "predicted": {"stable", "stiffness", "critical"} or
/// null, "expect": "stable", "unstable" or null, "metrics": {...}, "digest", "simulated_s",
/// "wall_s", "cpu_s", "fault": null or why it could not be run} on one line. Numbers have the
/// digits that give them back bit for bit; what is no number is null.
std::string LineOf(const CellRecord& record);

/// A results file in memory: a header and cells in the order of their numbers.
struct Results {
  ResultsHeader header;
  std::map<std::size_t, CellRecord> records;
};

/// A last line that was not written to its end, as it is when the program is killed, is passed
/// over. Errors name the file and the line.
Result<Results> ReadResults(const std::filesystem::path& file);

/// Writes them in the order of the cells, beside the file and then in its place.
std::optional<Error> WriteResults(const std::filesystem::path& file, const Results& results);

/// The results of all shards as one run of the whole sweep would give them, but for the times that
/// the cells took. Errors name what does not belong together, or what is missing.
Result<Results> Merge(const std::vector<std::filesystem::path>& files);

/// Takes down cells as they are done, so that a run that was ended by force goes on where it was.
class ResultsLog {
 public:
  /// Goes on with the file if there is one: it must have the same header.
  static Result<ResultsLog> Open(const std::filesystem::path& file, const ResultsHeader& header);

  /// What was there already, and what was added.
  const Results& results() const { return results_; }
  bool Has(const SweepCell& cell) const { return results_.records.contains(cell.number); }

  /// A line, which the system has when this returns.
  std::optional<Error> Add(const CellRecord& record);
  /// All is done: puts the lines in order.
  std::optional<Error> Finish();

 private:
  ResultsLog() = default;

  std::filesystem::path file_;
  Results results_;
  std::ofstream out_;
};

/// Of the cells' digests, in the order of their numbers.
std::string DigestOf(const Results& results);

}  // namespace tandem
