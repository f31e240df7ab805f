#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "collab/lab/sweep/results_file.h"
#include "collab/lab/sweep/sweep_summary.h"

namespace tandem {

/// A table of results other than a sweep's: boundaries, runs in real time, or users with bodies of
/// their own. Its texts are as they are shown.
struct ReportTable {
  std::string title;
  std::string note;  // facts that hold for all rows
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// A sweep's results, their summary and pictures.
struct ReportSweep {
  std::string name;  // unique name of letters, digits and "-", for names of files
  Results results;
  SweepSummary summary;
  std::vector<Picture> maps;
  std::vector<Picture> others;
  std::size_t maps_left_out = 0;
};

/// A cell that was run again to record its course in time.
struct ReportSeries {
  std::string cell;  // description in a line
  std::string why;
  std::string csv;  // name of the CSV file
  Picture picture;
  bool same = false;        // true: its digest is the sweep's
  bool same_build = false;  // true: the same build ran the sweep; false: digests may differ
};

struct ReportData {
  std::string command;  // command that makes this report
  std::string version;  // version of the program that makes it
  std::vector<ReportSweep> sweeps;
  std::vector<SweepRow> rows;  // rows of tables that have a bar
  std::vector<ReportTable> tables;
  std::vector<Picture> pictures;  // pictures of tables
  std::vector<ReportSeries> series;
  std::size_t searches = 0;  // searches for a boundary, each of many runs

  /// Returns the rows of all sweeps and tables. Adds a row that compares digests if cells were run
  /// again by the sweep's build.
  std::vector<SweepRow> AllRows() const;
  std::size_t cells() const;
};

/// Adds a file's content. The file has the results of a sweep (JSONL, or a folder with
/// cells.jsonl), or an object of JSON printed by a command of the lab. Each of its arrays of
/// objects is a table. `rows` of {"name", "bar", "value", "pass"} are claims that hold or not.
/// Errors name the file.
std::optional<Error> AddFile(const std::filesystem::path& file, ReportData& data);

}  // namespace tandem
