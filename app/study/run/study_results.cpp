#include "app/study/run/study_results.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/picture/svg.h"
#include "app/study/effect.h"
#include "app/study/results_table.h"
#include "app/study/study_page.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

void PrintStudyJson(const StudyRequest& request, const Study& study, const TrialLog& log,
                    const std::vector<ResultRow>& rows, const std::vector<MeasureEffect>& effects) {
  const auto count = [&rows, &study](TrialState state, const std::string* condition) {
    return std::ranges::count_if(rows, [&](const ResultRow& row) {
      return row.logged.state == state &&
             (condition == nullptr || study.conditions[row.plan.condition].name == *condition);
    });
  };
  nlohmann::ordered_json conditions = nlohmann::ordered_json::array();
  for (const StudyCondition& condition : study.conditions) {
    conditions.push_back({{"name", condition.name},
                          {"delay_ms", condition.delay_ms},
                          {"jitter_ms", condition.jitter_ms},
                          {"loss", condition.loss},
                          {"law", condition.law},
                          {"done", count(TrialState::kDone, &condition.name)}});
  }
  const nlohmann::ordered_json out{
      {"study", study.name},
      {"mode", log.header().mode},
      {"participants", log.consents().size()},
      {"trials", static_cast<std::size_t>(study.participants) * TrialsOf(study, 0).size()},
      {"done", count(TrialState::kDone, nullptr)},
      {"cut", count(TrialState::kCut, nullptr)},
      {"lost", count(TrialState::kLost, nullptr)},
      {"conditions", conditions},
      {"effect", nlohmann::ordered_json::parse(EffectsJson(study, effects))},
      {"results", (request.folder / "results.csv").string()}};
  PrintText(JsonText(out, 2));
}

}  // namespace

int WriteStudyResults(const StudyRequest& request, const Study& study, const TrialLog& log) {
  const std::vector<ResultRow> rows = RowsOf(study, log);
  const std::vector<MeasureEffect> effects = EffectsOf(study, rows);
  std::error_code failed;
  std::filesystem::create_directories(request.folder / "pictures", failed);
  if (failed) return Fail(kExitFile, request.folder.string() + ": " + failed.message());
  std::vector<std::pair<std::string, std::string>> files{
      {"results.csv", ResultsCsv(study, rows)},
      {"codebook.json", CodebookJson(study)},
      {"codebook.md", CodebookText(study)},
      {"effect.json", EffectsJson(study, effects) + "\n"},
      {"report.html", StudyPage(study, rows, effects, log.header().mode)}};
  for (const MeasureEffect& effect : effects) {
    const Picture picture = PictureOf(study, effect);
    files.emplace_back("pictures/" + picture.name + ".svg", SvgOf(picture, SvgPlace::kFile));
  }
  for (const auto& [name, content] : files) {
    if (const auto fault = WriteWholeFile(request.folder / name, content)) {
      return Fail(kExitFile, fault->what);
    }
    // a file of before keeps its permissions when it is written anew
    chmod((request.folder / name).c_str(), S_IRUSR | S_IWUSR);
  }
  if (request.json) PrintStudyJson(request, study, log, rows, effects);
  return kExitOk;
}

}  // namespace tandem
