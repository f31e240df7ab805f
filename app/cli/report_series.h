#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "app/stability/report_data.h"
#include "collab/lab/lab_scene.h"

namespace tandem {

/// The lab's scenes, each loaded once.
class LabScenes {
 public:
  /// Null: it is not at hand, which is said once on stderr.
  const LabScene* Of(const LabCase& test);

 private:
  std::map<std::pair<std::string, std::string>, std::optional<LabScene>> scenes_;
};

/// Runs at most so many of the sweeps' cells again (app/stability/chosen_cells.h), on all
/// processors: their courses in time go to the folder as CSV, their pictures and whether they came
/// to the same into the report.
std::optional<Error> AddSeries(std::size_t most, const std::filesystem::path& folder,
                               LabScenes& scenes, ReportData& data);

}  // namespace tandem
