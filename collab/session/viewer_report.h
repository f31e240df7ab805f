#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "collab/session/viewer.h"
#include "engine/base/result.h"

namespace tandem {

/// A viewer's report at the end of its run.
struct ViewerReport {
  int pid = 0;
  double seconds = 0;         // time in the session
  std::uint64_t samples = 0;  // view frames received
  double samples_per_s = 0;   // between the first and the newest
  std::optional<double>
      age_ms_p99;              // at arrival; none across hosts, whose clocks have nothing in common
  std::size_t peers_seen = 0;  // active peers
};

/// Returns the report on the session that `viewer` saw for `seconds`; null: it has seen none.
ViewerReport ReportOf(const Viewer* viewer, int pid, double seconds);

/// Returns one JSON object with the fields' names, indented.
std::string AsJson(const ViewerReport& report);

/// Writes the report; an error names the file.
Result<bool> WriteReport(const ViewerReport& report, const std::filesystem::path& file);

}  // namespace tandem
