#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "collab/viewer.h"
#include "engine/base/result.h"

namespace tandem {

/// What a viewer says of its run at the end.
struct ViewerReport {
  int pid = 0;
  double seconds = 0;         // in the session
  std::uint64_t samples = 0;  // view frames received
  double samples_per_s = 0;   // between the first and the newest
  std::optional<double>
      age_ms_p99;              // at arrival; none across hosts, whose clocks have nothing in common
  std::size_t peers_seen = 0;  // active ones
};

/// Of the session that `viewer` has been in for `seconds`; null: it has been in none.
ViewerReport ReportOf(const Viewer* viewer, int pid, double seconds);

/// One JSON object with the fields' names, indented.
std::string AsJson(const ViewerReport& report);

/// Writes it; the error names the file.
Result<bool> WriteReport(const ViewerReport& report, const std::filesystem::path& file);

}  // namespace tandem
