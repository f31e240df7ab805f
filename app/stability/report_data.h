#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "collab/lab/results_file.h"
#include "collab/lab/sweep_summary.h"

namespace tandem {

/// A table of something beside sweeps: of a boundary, of real time, of users
/// with bodies of their own. Its texts are as they are shown.
struct ReportTable {
  std::string title;
  std::string note;  // what holds of all rows
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// A sweep's results and what they come to.
struct ReportSweep {
  std::string name;  // unlike the others', of letters, digits and "-": in files' names
  Results results;
  SweepSummary summary;
  std::vector<Picture> maps;
  std::vector<Picture> others;
  std::size_t maps_left_out = 0;
};

/// A cell that was run again for its course in time.
struct ReportSeries {
  std::string cell;  // in one line
  std::string why;
  std::string csv;  // its file's name
  Picture picture;
  bool same = false;        // its digest is the sweep's
  bool same_build = false;  // by which the sweep was run: else digests may differ
};

struct ReportData {
  std::string command;  // that makes this report
  std::string version;  // of the program that makes it
  std::vector<ReportSweep> sweeps;
  std::vector<SweepRow> rows;  // of tables that have a bar
  std::vector<ReportTable> tables;
  std::vector<Picture> pictures;  // of tables
  std::vector<ReportSeries> series;
  std::size_t searches = 0;  // for a boundary, many runs each

  /// Of all sweeps and tables; a row that cells were run again if there are
  /// series.
  std::vector<SweepRow> AllRows() const;
  std::size_t cells() const;
};

/// Adds what the file holds: results of a sweep (JSONL, or a folder with
/// cells.jsonl), or an object of JSON that a command of the lab printed: each
/// of its arrays of objects is a table, and `rows` of {"name", "bar", "value",
/// "pass"} are claims that hold or not. Errors name the file.
std::optional<Error> AddFile(const std::filesystem::path& file, ReportData& data);

}  // namespace tandem
