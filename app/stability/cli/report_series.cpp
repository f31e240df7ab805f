#include "app/stability/cli/report_series.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <thread>
#include <vector>

#include "app/common/console.h"
#include "app/stability/cli/sweep_outcome.h"
#include "app/stability/live/lab_scenes.h"
#include "app/stability/report/cell_facts.h"
#include "app/stability/report/chosen_cells.h"
#include "app/stability/report/series.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/metrics/series_file.h"
#include "collab/lab/run/case_run.h"
#include "collab/lab/sweep/sweep_run.h"

namespace tandem {

namespace {

constexpr double kMostSeriesLines = 4000;  // lines of a file

struct Rerun {
  const CellRecord* record = nullptr;
  LabCase test;
  const LabScene* scene = nullptr;
  ReportSeries series;
  std::optional<Error> fault;
};

void Run(const std::filesystem::path& folder, Rerun& rerun) {
  const double seconds = rerun.test.seconds > 0 ? rerun.test.seconds : rerun.test.DefaultDuration();
  const int every = std::max(1, static_cast<int>(std::ceil(1e3 * seconds / kMostSeriesLines)));
  const std::filesystem::path csv = folder / rerun.series.csv;
  Result<SeriesFile> file = SeriesFile::Create(csv, rerun.test.users, every);
  if (!file) {
    rerun.fault = file.error();
    return;
  }
  const CaseResult result =
      RunCase(rerun.test, *rerun.scene, [&file](double t_s, std::span<const UserFrame> users) {
        file->Add(t_s, users);
      });
  rerun.series.same = result.digest == rerun.record->outcome.result.digest;
  if ((rerun.fault = file->Close())) return;
  const Result<Series> series = ReadSeries(csv);
  if (!series) {
    rerun.fault = series.error();
    return;
  }
  const Metrics& m = result.metrics;
  rerun.series.picture =
      PictureOf(*series, csv.stem().string(), rerun.series.cell,
                rerun.series.why + ": " + NameOf(result.verdict) + ", growth " +
                    TableNumber(m.growth) + "/s, tail " + TableNumber(1e3 * m.tail_rms) +
                    " mm/s, energy " + TableNumber(1e3 * m.generated_J) + " mJ");
}

}  // namespace

const LabScene* LabScenes::SceneFor(const LabCase& test) {
  const auto key = std::make_pair(test.scene, test.body);
  const auto found = scenes_.find(key);
  if (found != scenes_.end()) return found->second ? &*found->second : nullptr;
  std::optional<LabScene>& scene = scenes_[key];
  if (Result<LabScene> loaded = LoadLabScene(test, LabSceneFolder())) {
    scene = *std::move(loaded);
  } else {
    Say(loaded.error().what + "; the report has no theory and no time series of that scene");
  }
  return scene ? &*scene : nullptr;
}

std::optional<Error> AddSeries(std::size_t most, const std::filesystem::path& folder,
                               LabScenes& scenes, ReportData& data) {
  if (most == 0 || data.sweeps.empty()) return std::nullopt;
  const std::size_t each = std::max<std::size_t>(1, most / data.sweeps.size());
  const std::string program = ProgramDigest();
  std::vector<Rerun> reruns;
  for (const ReportSweep& sweep : data.sweeps) {
    for (const ChosenCell& chosen : ChooseCells(sweep.results, each)) {
      const CellRecord& record = sweep.results.records.at(chosen.number);
      const Result<LabCase> test = ParseCase(record.cell.case_json, "cell");
      const LabScene* const scene = test ? scenes.SceneFor(*test) : nullptr;
      if (scene == nullptr) continue;
      Rerun& rerun = reruns.emplace_back();
      rerun.record = &record;
      rerun.test = FittedTo(scene->inertia(), *test);
      rerun.scene = scene;
      rerun.series.cell = LineOf(record, FactsOf(record));
      rerun.series.why = chosen.why;
      rerun.series.csv = sweep.name + "-cell-" + std::to_string(chosen.number) + ".csv";
      rerun.series.same_build = sweep.results.header.program == program;
    }
  }
  if (reruns.empty()) return std::nullopt;
  Say("runs " + std::to_string(reruns.size()) + " cells again for their time series");
  std::vector<SweepCell> cells;
  for (std::size_t i = 0; i < reruns.size(); ++i) cells.emplace_back().number = i;
  RunCells(
      cells, std::max(1U, std::thread::hardware_concurrency()),
      [&](const SweepCell& cell) {
        Run(folder, reruns[cell.number]);
        return CellOutcome{};
      },
      [](const SweepCell&, const CellOutcome&) {});
  for (Rerun& rerun : reruns) {
    if (rerun.fault) return rerun.fault;
    data.series.push_back(std::move(rerun.series));
  }
  return std::nullopt;
}

}  // namespace tandem
