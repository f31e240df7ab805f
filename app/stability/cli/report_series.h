#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "app/stability/report/report_data.h"
#include "collab/lab/case/lab_scene.h"

namespace tandem {

/// Keeps the lab's scenes, each loaded once.
class LabScenes {
 public:
  /// Returns the scene of a case; null: it is not at hand, which is said once on stderr.
  const LabScene* SceneFor(const LabCase& test);

 private:
  std::map<std::pair<std::string, std::string>, std::optional<LabScene>> scenes_;
};

/// Runs some of the sweeps' cells again (app/stability/report/chosen_cells.h), on all processors:
/// about `most`, and at least one of each sweep. Their courses in time go to the folder as CSV. The
/// report gets their pictures, and whether they came to the same result.
std::optional<Error> AddSeries(std::size_t most, const std::filesystem::path& folder,
                               LabScenes& scenes, ReportData& data);

}  // namespace tandem
