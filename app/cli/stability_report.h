#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem {

/// What a report of the stability lab is made of.
struct ReportRequest {
  std::vector<std::filesystem::path> files;  // results of sweeps, JSON of other commands
  std::filesystem::path folder;              // made if it is not there
  std::string command;                       // as the report tells it
  std::size_t series = 12;                   // cells that are run again for their course in time
};

/// Writes into the folder: report.html, which needs none of the others;
/// report.json; a CSV of each sweep, table and course in time; each picture as
/// SVG and, where tandem-view is at hand, as PNG. Says on stderr what it does.
/// Gives the exit code: what is wrong with a file, not whether rows pass.
int MakeReport(const ReportRequest& request);

}  // namespace tandem
