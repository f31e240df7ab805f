#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/progress_bar.h"
#include "app/judgement/start_gaps.h"
#include "app/stability/cli/stability_command.h"
#include "app/stability/cli/stability_report.h"
#include "app/stability/cli/sweep_outcome.h"
#include "app/stability/live/lab_scenes.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/case/lab_scene.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

struct SweepArguments {
  std::string file;
  std::string out;
  std::string report;  // folder
  std::string shard = "1/1";
  unsigned jobs = 0;        // 0: as many as processors
  std::int64_t print = -1;  // cell whose case is printed, in place of running any
  bool progress = false;
  bool json = false;
};

/// Keeps the cells' cases with their scenes, each scene made once.
class Cases {
 public:
  explicit Cases(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<Error> Add(const SweepCell& cell) {
    Result<LabCase> test =
        ParseCase(cell.case_json, "cell " + std::to_string(cell.number), folder_);
    if (!test) return test.error();
    // a relative scene file lies in the sweep's folder
    const std::filesystem::path file = test->scene;
    if (file.extension() == ".json" && file.is_relative()) test->scene = (folder_ / file).string();
    const auto key = std::make_pair(test->scene, test->body);
    if (!scenes_.contains(key)) {
      Result<LabScene> scene = LoadLabScene(*test, LabSceneFolder());
      if (!scene) return scene.error();
      TellStart(FindStartGaps(*scene->model));
      scenes_.emplace(key, *std::move(scene));
    }
    const LabScene& scene = scenes_.at(key);
    cases_.emplace(cell.number, Case{FittedTo(scene.inertia(), *std::move(test)), &scene});
    return std::nullopt;
  }

  CellOutcome Run(const SweepCell& cell) const {
    const Case& one = cases_.at(cell.number);
    const std::int64_t wall_ns = MonotonicNowNs();
    const std::int64_t cpu_ns = MachineClock().ThreadCpuNs();
    CellOutcome outcome;
    outcome.predicted = Predict(one.test, one.scene->inertia());
    outcome.result = RunCase(one.test, *one.scene);
    outcome.wall_s = ToSeconds(MonotonicNowNs() - wall_ns);
    outcome.cpu_s = ToSeconds(MachineClock().ThreadCpuNs() - cpu_ns);
    return outcome;
  }

 private:
  struct Case {
    LabCase test;
    const LabScene* scene;
  };

  std::filesystem::path folder_;
  std::map<std::pair<std::string, std::string>, LabScene> scenes_;
  std::map<std::size_t, Case> cases_;
};

/// Collects outcomes, in a file if there is one.
class Outcomes {
 public:
  explicit Outcomes(const ResultsHeader& header) { results_.header = header; }

  std::optional<Error> Open(const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed) return Error{folder.string() + ": " + failed.message()};
    Result<ResultsLog> log = ResultsLog::Open(folder / "cells.jsonl", results_.header);
    if (!log) return log.error();
    log_.emplace(*std::move(log));
    return std::nullopt;
  }
  bool Has(const SweepCell& cell) const { return log_ && log_->Has(cell); }
  void Add(const SweepCell& cell, const CellOutcome& outcome) {
    if (!log_) {
      results_.records.insert_or_assign(cell.number, CellRecord{cell, outcome});
    } else if (!failed_) {
      failed_ = log_->Add({cell, outcome});
    }
  }
  std::optional<Error> Finish() {
    if (log_ && !failed_) failed_ = log_->Finish();
    return failed_;
  }
  const Results& results() const { return log_ ? log_->results() : results_; }

 private:
  Results results_;
  std::optional<ResultsLog> log_;
  std::optional<Error> failed_;
};

int PrintCase(const Sweep& sweep, std::int64_t number) {
  const auto index = static_cast<std::size_t>(number);
  if (index >= sweep.cells.size()) {
    return Fail(kExitUsage, "the sweep has cells 0 to " + std::to_string(sweep.cells.size() - 1));
  }
  PrintText(sweep.cells[index].case_json);
  return kExitOk;
}

int RunStabilitySweep(const SweepArguments& arguments) {
  const Result<Shard> shard = ParseShard(arguments.shard);
  if (!shard) return Fail(kExitUsage, shard.error().what);
  const std::filesystem::path folder = std::filesystem::path(arguments.file).parent_path();
  const Result<Sweep> sweep =
      LoadSweep(arguments.file, [&folder](const std::string& text, const std::string& name) {
        const Result<LabCase> test = ParseCase(text, name, folder);
        return test ? std::nullopt : std::optional<Error>(test.error());
      });
  if (!sweep) return Fail(kExitFile, sweep.error().what);
  if (arguments.print >= 0) return PrintCase(*sweep, arguments.print);

  Outcomes outcomes({.sweep = sweep->name,
                     .seed = sweep->seed,
                     .sweep_hash = sweep->hash,
                     .version = TANDEM_VERSION,
                     .program = ProgramDigest(),
                     .cells = sweep->cells.size(),
                     .shard = shard->Name(),
                     .command = "tandem stability sweep " + arguments.file});
  if (!arguments.out.empty()) {
    if (const auto failed = outcomes.Open(arguments.out)) return Fail(kExitFile, failed->what);
  }
  Cases cases(folder);
  std::vector<SweepCell> rest;
  double cost = 0;
  std::size_t before = 0;
  for (const SweepCell& cell : sweep->cells) {
    if (!shard->Has(cell)) continue;
    if (outcomes.Has(cell)) {
      ++before;
      continue;
    }
    if (const auto failed = cases.Add(cell)) return Fail(kExitFile, failed->what);
    rest.push_back(cell);
    cost += cell.cost;
  }
  if (before > 0) Say(std::to_string(before) + " cells are done already");

  SweepRun run{.jobs = arguments.jobs != 0 ? arguments.jobs
                                           : std::max(1U, std::thread::hardware_concurrency()),
               .json = arguments.json};
  const std::int64_t began_ns = MonotonicNowNs();
  {
    ProgressBar bar(rest.size(), arguments.progress);
    bar.Show(0, 0);
    double paid = 0;
    std::size_t done = 0;
    RunCells(
        rest, run.jobs,
        [&cases](const SweepCell& cell) {
          return cases.Run(cell);
        },
        [&](const SweepCell& cell, const CellOutcome& outcome) {
          outcomes.Add(cell, outcome);
          paid += cell.cost;
          bar.Show(++done, paid / cost);
        });
  }
  run.wall_s = ToSeconds(MonotonicNowNs() - began_ns);
  std::optional<Error> failed = outcomes.Finish();
  if (!failed && !arguments.out.empty()) {
    failed =
        WriteSummary(std::filesystem::path(arguments.out) / "cells.jsonl", outcomes.results(), run);
  }
  if (failed) return Fail(kExitFile, failed->what);
  const int outcome = TellOutcome(outcomes.results(), run);
  if (arguments.report.empty()) return outcome;
  const int made = MakeReport(
      {.files = {std::filesystem::path(arguments.out) / "cells.jsonl"},
       .folder = arguments.report,
       .command = "tandem stability sweep " + arguments.file + " --report " + arguments.report});
  return made != kExitOk ? made : outcome;
}

}  // namespace

void AddStabilitySweep(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<SweepArguments>();
  CLI::App* command = stability.add_subcommand(
      "sweep", "Run a grid of cases on all processors; exit code 1 if a row of its table fails");
  command->add_option("file", arguments->file, "sweep file (JSON, docs/stability-cluster.md)")
      ->required();
  command->add_option(
      "--out", arguments->out,
      "folder for cells.jsonl and summary.json; the sweep does not repeat cells that are there");
  command
      ->add_option("--shard", arguments->shard,
                   "part to run, i/n: one of n equal parts, to be merged with the others")
      ->capture_default_str();
  command
      ->add_option("--jobs", arguments->jobs,
                   "number of cells at a time; default: one for each processor")
      ->check(WholeNumberFrom(1, kMostThreads));
  command
      ->add_option(
          "--print", arguments->print,
          "number of a cell whose case to print, as `stability run` reads it; runs nothing")
      ->check(WholeNumberFrom(0, 100'000'000));
  command->add_flag("--progress", arguments->progress,
                    "show progress even if stderr is not a terminal");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->add_option(
      "--report", arguments->report,
      "folder for the report (tandem stability report), and for the results if --out is not given");
  command->callback([arguments, &exit_code] {
    if (arguments->out.empty()) arguments->out = arguments->report;
    exit_code = RunStabilitySweep(*arguments);
  });
}

}  // namespace tandem
