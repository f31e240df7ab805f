#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem {

/// The parts of a report of the stability lab.
struct ReportRequest {
  std::vector<std::filesystem::path> files;  // results of sweeps, JSON of other commands
  std::filesystem::path folder;              // made if it is not there
  std::string command;                       // command line that the report shows
  std::size_t series = 12;                   // cells that are run again for their course in time
};

/// Writes report.html, report.json and a CSV of each sweep, table and course in time into the
/// folder. report.html needs no other file. It writes each picture as SVG and, where tandem-view is
/// at hand, as PNG. Says on stderr what it does. Returns the exit code, which tells of faulty
/// files, not of rows that fail.
int MakeReport(const ReportRequest& request);

}  // namespace tandem
