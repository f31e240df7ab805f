#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/judgement/start_gaps.h"
#include "app/stability/cli/stability_command.h"
#include "app/stability/live/lab_scenes.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/case/prediction.h"
#include "collab/lab/metrics/metrics_table.h"
#include "collab/lab/metrics/series_file.h"
#include "collab/lab/run/case_run.h"
#include "engine/base/text/hex.h"
#include "engine/base/text/json_text.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

struct RunArguments {
  std::string file;
  std::string series;
  int every_ms = 1;
  bool json = false;
};

struct Timed {
  CaseResult result;
  std::optional<Prediction> predicted;
  double cpu_s = 0;

  double speed() const { return cpu_s > 0 ? result.simulated_s / cpu_s : 0.0; }
};

OrderedJson JsonOf(const LabCase& test, const Timed& run) {
  OrderedJson metrics = OrderedJson::object();
  for (const MetricField& field : MetricFields()) {
    std::visit(
        [&](auto member) {
          metrics[std::string(field.name)] = run.result.metrics.*member;
        },
        field.member);
  }
  OrderedJson predicted;
  if (run.predicted) {
    predicted = {{"stable", run.predicted->is_stable()},
                 {"stiffness", run.predicted->stiffness},
                 {"critical", run.predicted->critical},
                 {"covers", NameOf(run.predicted->covers)}};
  }
  return {{"name", test.name},
          {"verdict", NameOf(run.result.verdict)},
          {"predicted", predicted},
          {"metrics", metrics},
          {"digest", Hex(run.result.digest)},
          {"simulated_s", run.result.simulated_s},
          {"cpu_s", run.cpu_s},
          {"speed", run.speed()}};
}

/// Prints how long the run took, if it ended early or went on.
void PrintLength(const LabCase& test, const Timed& run) {
  const Metrics& m = run.result.metrics;
  const double lasted_s = kFrame * static_cast<double>(m.frames);
  if (m.diverged) {
    PrintLine("  ended             %9.2f s after the loops closed, %s", lasted_s,
              std::isfinite(m.last_apart) && m.peak_apart >= 0.5 ? "0.5 m apart" : "not a number");
  } else if (lasted_s > 1.5 * test.Duration()) {
    PrintLine("  extended          %9.2f s instead of %.2f s, because it decayed", lasted_s,
              test.Duration());
  }
  if (run.result.verdict == Verdict::kUndecided) {
    PrintLine("  undecided         %s",
              DecaysAboveRest(m) ? "it decays but is not at rest: give the case more seconds"
                                 : "too short to measure growth: give the case more seconds");
  }
}

void Print(const LabCase& test, const Timed& run) {
  const Metrics& m = run.result.metrics;
  PrintLine("%s: %s", test.name.empty() ? "case" : test.name.c_str(), NameOf(run.result.verdict));
  PrintLength(test, run);
  if (m.windows < 2) {
    PrintLine("  growth            not measured: the run ended too early");
  } else {
    PrintLine("  growth            %+9.3f /s over %d windows", m.growth, m.windows);
  }
  PrintLine("  tail RMS          %9.4f mm/s", 1e3 * m.tail_rms);
  PrintLine("  energy generated  %9.4f mJ", 1e3 * m.generated_J);
  PrintLine("  divergence        %9.2f mm at the most, %.2f mm at the end", 1e3 * m.peak_apart,
            1e3 * m.last_apart);
  if (std::isnan(m.settle_s)) {
    PrintLine("  settles               never");
  } else {
    PrintLine("  settles           %9.2f s after the last input", m.settle_s);
  }
  PrintLine("  rotated apart     %9.3f rad at the most", m.peak_turn);
  PrintLine("  RMS 0.2-5 Hz      %9.4f mm/s, 5-100 Hz %.4f mm/s", 1e3 * m.band_low_rms,
            1e3 * m.band_high_rms);
  PrintLine("  hand's force      %9.2f N, %.0f N/s at the most; limited in %.1f %%", m.peak_force,
            m.peak_force_rate, 1e2 * m.guarded_share);
  PrintLine("  link's force      %9.2f N, %.0f N/s at the most; gate acts in %.1f %%", m.link_force,
            m.link_force_rate, 1e2 * m.clip_share);
  PrintLine("  stiffness         %9.1f N/m of a link at the end, %.1f N/m at the least",
            m.stiffness, m.least_stiffness);
  PrintLine("  loop age          %9.1f ms, gains are for %.1f ms one way", 1e3 * m.loop_age_s,
            1e3 * m.te_s);
  if (run.predicted) {
    PrintLine(
        "  theory            %s: %.1f N/m of all links of a user, unstable from %.1f N/m on (%s)",
        run.predicted->is_stable() ? "stable" : "not certainly stable", run.predicted->stiffness,
        run.predicted->critical, NameOf(run.predicted->covers));
  }
  PrintLine("%.1f s simulated in %.2f s of processor time: %.0f times as fast",
            run.result.simulated_s, run.cpu_s, run.speed());
}

int RunStabilityRun(const RunArguments& arguments) {
  const Result<LabCase> test = LoadCase(arguments.file);
  if (!test) return Fail(kExitFile, test.error().what);
  const Result<LabScene> scene = LoadLabScene(*test, LabSceneFolder());
  if (!scene) return Fail(kExitFile, scene.error().what);
  TellStart(FindStartGaps(*scene->model));
  std::optional<SeriesFile> series;
  SeriesSink sink;
  if (!arguments.series.empty()) {
    Result<SeriesFile> created =
        SeriesFile::Create(arguments.series, test->users, arguments.every_ms);
    if (!created) return Fail(kExitFile, created.error().what);
    series = std::move(*created);
    sink = [&series](double t_s, std::span<const UserFrame> users) {
      series->Add(t_s, users);
    };
  }
  Timed run;
  const std::int64_t began_ns = MachineClock().ThreadCpuNs();
  run.result = RunCase(*test, *scene, sink);
  run.cpu_s = ToSeconds(MachineClock().ThreadCpuNs() - began_ns);
  if (run.result.fault) {
    return Fail(kExitFailed, arguments.file + ": " + run.result.fault->what);
  }
  if (series) {
    if (const auto fault = series->Close()) return Fail(kExitFile, fault->what);
  }
  run.predicted = Predict(FittedTo(scene->inertia(), *test), scene->inertia());
  if (arguments.json) {
    PrintText(JsonText(JsonOf(*test, run), 2));
  } else {
    Print(*test, run);
  }
  return run.result.verdict == Verdict::kStable ? kExitOk : kExitFailed;
}

}  // namespace

void AddStabilityRun(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = stability.add_subcommand(
      "run", "Run one case and print all its measures; exit code 1 if it is not stable");
  command->add_option("case", arguments->file, "case file (JSON, docs/stability.md)")->required();
  command->add_option("--series", arguments->series, "time series file to write (CSV)")
      ->check(FileEndingIn({".csv"}));
  command->add_option("--every-ms", arguments->every_ms, "with --series: time between lines, ms")
      ->capture_default_str()
      ->check(WholeNumberFrom(1, 1000));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunStabilityRun(*arguments);
  });
}

}  // namespace tandem
