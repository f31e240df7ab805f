#include <algorithm>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/progress_bar.h"
#include "app/stability/cli/report_series.h"
#include "app/stability/cli/stability_command.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/case/lab_scene.h"
#include "collab/lab/sweep/random_cells.h"
#include "collab/lab/sweep/random_verdict.h"
#include "engine/base/text/json_text.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

struct RandomArguments {
  std::size_t seeds = 1000;
  std::uint64_t first = 1;
  unsigned jobs = 0;        // 0: as many as processors
  std::int64_t print = -1;  // seed whose case is printed, in place of running any
  bool progress = false;
  bool json = false;
};

/// A drawn case that fails, and its remaining speed with its links cut, m/s.
struct FailingCase {
  const RandomRecord* record = nullptr;
  double tail_without_links = 0;
};

OrderedJson JsonOf(const FailingCase& failing) {
  const RandomRecord& record = *failing.record;
  const Metrics& m = record.outcome.result.metrics;
  OrderedJson why = OrderedJson::array();
  for (const std::string& reason : record.reasons) why.push_back(reason);
  return {{"seed", record.seed},
          {"why", why},
          {"verdict", NameOf(record.outcome.result.verdict)},
          {"growth", m.growth},
          {"tail_rms_mm_s", 1e3 * m.tail_rms},
          {"energy_mJ", 1e3 * m.generated_J},
          {"peak_apart_mm", 1e3 * m.peak_apart},
          {"tail_rms_without_links_mm_s", 1e3 * failing.tail_without_links},
          {"simulated_s", record.outcome.result.simulated_s},
          {"case", OrderedJson::parse(record.case_json)}};
}

OrderedJson JsonOf(const RandomSummary& summary, std::span<const FailingCase> failing,
                   const RandomArguments& arguments, double wall_s) {
  OrderedJson worst = OrderedJson::array();
  for (const FailingCase& one : failing) worst.push_back(JsonOf(one));
  return {{"cells", summary.cells},
          {"first", arguments.first},
          {"pass", summary.failing == 0},
          {"failing", summary.failing},
          {"not_stable", summary.not_stable},
          {"predicted_stable", summary.predicted_stable},
          {"predicted_stable_measured_unstable", summary.predicted_stable_measured_unstable},
          {"max_energy_mJ", summary.max_energy_mJ},
          {"max_tail_rms_mm_s", summary.max_tail_rms_mm_s},
          {"simulated_s", summary.simulated_s},
          {"cpu_s", summary.cpu_s},
          {"wall_s", wall_s},
          {"digest", summary.digest},
          {"worst", worst}};
}

void Print(const RandomSummary& summary, std::span<const FailingCase> failing, double wall_s) {
  PrintLine("%zu cells: %zu not stable, %zu of %zu predicted stable measured unstable",
            summary.cells, summary.not_stable, summary.predicted_stable_measured_unstable,
            summary.predicted_stable);
  PrintLine("  energy generated  at most %9.4f mJ, %.0f allowed", summary.max_energy_mJ,
            1e3 * kMostRandomEnergy);
  PrintLine("  tail RMS          at most %9.4f mm/s, %.1f allowed", summary.max_tail_rms_mm_s,
            1e3 * kMostRandomTail);
  PrintLine("  %.0f s simulated in %.0f s (%.0f s of processors), digest %s", summary.simulated_s,
            wall_s, summary.cpu_s, summary.digest.c_str());
  for (const FailingCase& one : failing) {
    const RandomRecord& record = *one.record;
    std::string why;
    for (const std::string& reason : record.reasons) why += (why.empty() ? "" : ", ") + reason;
    PrintLine("  seed %llu: %s; tail %.4f mm/s, %.4f with the links cut",
              static_cast<unsigned long long>(record.seed), why.c_str(),
              1e3 * record.outcome.result.metrics.tail_rms, 1e3 * one.tail_without_links);
    PrintLine("    %s", record.case_json.c_str());
  }
}

int RunStabilityRandom(const RandomArguments& arguments) {
  if (arguments.print >= 0) {
    PrintText(RandomCase(static_cast<std::uint64_t>(arguments.print)));
    return kExitOk;
  }
  const std::vector<SweepCell> cells = RandomCells(arguments.first, arguments.seeds);
  LabScenes scenes;
  std::vector<std::pair<LabCase, const LabScene*>> cases;
  double cost = 0;
  for (const SweepCell& cell : cells) {
    Result<LabCase> test = ParseCase(cell.case_json, "a drawn case");
    if (!test) return Fail(kExitFailed, test.error().what);
    const LabScene* const scene = scenes.SceneFor(*test);
    if (scene == nullptr) return kExitFile;  // the scenes have said why
    cases.emplace_back(FittedTo(scene->inertia(), *std::move(test)), scene);
    cost += cell.cost;
  }
  const unsigned jobs =
      arguments.jobs != 0 ? arguments.jobs : std::max(1U, std::thread::hardware_concurrency());
  RandomJudge judge(arguments.first);
  const std::int64_t began_ns = MonotonicNowNs();
  {
    ProgressBar bar(cells.size(), arguments.progress);
    bar.Show(0, 0);
    double paid = 0;
    std::size_t done = 0;
    RunCells(
        cells, jobs,
        [&cases](const SweepCell& cell) {
          const auto& [test, scene] = cases[cell.number];
          const std::int64_t cpu_ns = MachineClock().ThreadCpuNs();
          CellOutcome outcome = RunRandomCase(test, *scene);
          outcome.cpu_s = ToSeconds(MachineClock().ThreadCpuNs() - cpu_ns);
          return outcome;
        },
        [&](const SweepCell& cell, const CellOutcome& outcome) {
          judge.See(cell, outcome);
          paid += cell.cost;
          bar.Show(++done, paid / cost);
        });
  }
  const double wall_s = ToSeconds(MonotonicNowNs() - began_ns);
  const RandomSummary summary = judge.Finish();
  std::vector<FailingCase> failing;
  for (const RandomRecord& record : summary.worst) {
    const auto& [test, scene] = cases[record.seed - arguments.first];
    failing.push_back({&record, TailWithoutLinks(test, *scene)});
  }
  if (arguments.json) {
    PrintText(JsonText(JsonOf(summary, failing, arguments, wall_s), 2));
  } else {
    Print(summary, failing, wall_s);
  }
  return summary.failing == 0 ? kExitOk : kExitFailed;
}

}  // namespace

void AddStabilityRandom(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<RandomArguments>();
  CLI::App* command = stability.add_subcommand(
      "random", "Run cases drawn by seed under the default law; exit code 1 if one is not calm");
  command->add_option("--seeds", arguments->seeds, "number of cases")
      ->check(WholeNumberFrom(1, 250'000))
      ->capture_default_str();
  command
      ->add_option("--first", arguments->first,
                   "seed of the first case; the next cases have the next seeds")
      ->check(WholeNumberFrom(0, 1'000'000'000))
      ->capture_default_str();
  command
      ->add_option("--jobs", arguments->jobs,
                   "number of cases at a time; default: one for each processor")
      ->check(WholeNumberFrom(1, kMostThreads));
  command
      ->add_option("--print", arguments->print,
                   "seed of a case to print, as `stability run` reads it; runs nothing")
      ->check(WholeNumberFrom(0, 1'000'000'000));
  command->add_flag("--progress", arguments->progress,
                    "show progress even if stderr is not a terminal");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunStabilityRandom(*arguments);
  });
}

}  // namespace tandem
