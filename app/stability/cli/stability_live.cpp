#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/judgement/start_gaps.h"
#include "app/process/child_processes.h"
#include "app/stability/cli/stability_command.h"
#include "app/stability/live/lab_scenes.h"
#include "app/stability/live/live_comparison.h"
#include "app/stability/live/live_run.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/metrics/metrics_table.h"
#include "collab/lab/run/case_run.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct LiveArguments {
  std::string file;
  std::string keep;  // folder for recordings; empty: none are kept
  double bar = 0.1;
  bool tap = false;
  bool json = false;
};

/// Returns why live peers cannot run a case; empty: they can.
std::string NotLive(const LabCase& test, bool tap) {
  if (test.law.exchange_forces) return "live peers never exchange forces";
  const std::vector<LabNetwork::Step>& schedule = test.network.schedule;
  if (tap && !schedule.empty())
    return "--tap: the delays of real packets cannot change: leave --tap out";
  for (const LabNetwork::Step& step : schedule) {
    if (step.cut)
      return "a live peer cannot simulate an outage, which ends links: its conditioner cuts motion "
             "alone";
  }
  return "";
}

std::string ShortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

OrderedJson MetricsJson(const Metrics& metrics) {
  OrderedJson json = OrderedJson::object();
  for (const MetricField& field : MetricFields()) {
    std::visit(
        [&](auto member) {
          json[std::string(field.name)] = metrics.*member;
        },
        field.member);
  }
  return json;
}

/// A comparison of both runs, figure by figure.
struct LiveFigures {
  bool within = true;  // all judged figures agree
  OrderedJson comparison = OrderedJson::array();
  OrderedJson rows = OrderedJson::array();  // the judged figures, as rows of a table of bars
};

LiveFigures CompareFigures(const Metrics& real, const Metrics& simulated, double bar) {
  LiveFigures figures;
  for (const ComparedFigure& figure : ComparedFigures()) {
    const double off = DeviationOf(figure, real, simulated);
    figures.comparison.push_back({{"figure", figure.name},
                                  {"unit", figure.unit},
                                  {"virtual", figure.scale * simulated.*figure.value},
                                  {"live", figure.scale * real.*figure.value},
                                  {"off", off}});
    if (!figure.judged) continue;
    const bool pass = std::abs(off) <= bar;
    figures.within = figures.within && pass;
    figures.rows.push_back(
        {{"name", std::string("live compared with virtual time, off in ") + figure.name},
         {"bar", "<= " + ShortNumber(bar)},
         {"value", std::abs(off)},
         {"pass", pass}});
  }
  return figures;
}

OrderedJson LiveJson(const LiveArguments& arguments, const LabCase& test, const LiveTries& tries,
                     const CaseResult& simulated, const LiveFigures& figures) {
  const LiveRun& live = tries.last;
  return {{"case", test.name},
          {"users", test.users},
          {"network", arguments.tap ? "TAP hub" : "link conditioner"},
          {"runs", tries.count},
          {"kept", arguments.keep.empty() ? OrderedJson() : OrderedJson(tries.folder.string())},
          {"scheduler", live.scheduler},
          {"frames", live.frames},
          {"missed", live.missed},
          {"missed_share", live.missed_share()},
          {"bar", arguments.bar},
          {"within", figures.within},
          {"verdict_virtual", NameOf(simulated.verdict)},
          {"verdict_live", NameOf(live.run.verdict)},
          {"rows", figures.rows},
          {"comparison", figures.comparison},
          {"metrics_virtual", MetricsJson(simulated.metrics)},
          {"metrics_live", MetricsJson(live.run.metrics)}};
}

void PrintLive(const LiveArguments& arguments, const std::string& name, const LiveRun& live,
               const CaseResult& simulated) {
  const Metrics& real = live.run.metrics;
  PrintLine("%-26s %12s %12s %8s", name.c_str(), "virtual", "live", "off");
  for (const ComparedFigure& figure : ComparedFigures()) {
    PrintLine("%-26s %12.3f %12.3f %+7.1f %% %s%s", figure.name,
              figure.scale * simulated.metrics.*figure.value, figure.scale * real.*figure.value,
              1e2 * DeviationOf(figure, real, simulated.metrics), figure.unit,
              figure.judged ? " *" : "");
  }
  PrintLine("%-26s %12s %12s", "verdict", NameOf(simulated.verdict), NameOf(live.run.verdict));
  PrintLine("* must agree to %.0f %%; frames missed: %.2f %%, %s, delays by the %s",
            1e2 * arguments.bar, 1e2 * live.missed_share(), live.scheduler.c_str(),
            arguments.tap ? "TAP hub" : "link conditioner");
}

int RunStabilityLive(const LiveArguments& arguments) {
  const Result<LabCase> read = LoadCase(arguments.file);
  if (!read) return Fail(kExitFile, read.error().what);
  if (const std::string why = NotLive(*read, arguments.tap); !why.empty()) {
    return Fail(kExitUsage, arguments.file + ": cannot run live: " + why);
  }
  const Result<LabScene> scene = LoadLabScene(*read, LabSceneFolder());
  if (!scene) return Fail(kExitFile, scene.error().what);
  TellStart(FindStartGaps(*scene->model));
  // both runs last equally long: in virtual time a case without a length may go on
  LabCase timed = *read;
  timed.seconds = timed.Duration();
  const LabCase test = FittedTo(scene->inertia(), timed);
  const CaseResult simulated = RunCase(timed, *scene);
  if (simulated.fault) return Fail(kExitFailed, arguments.file + ": " + simulated.fault->what);

  const auto run = [&](const fs::path& folder) {
    return RunLive(test, *scene, folder, arguments.tap);
  };
  const Result<LiveTries> tries = TryLive(arguments.keep, run);
  if (!tries) return Fail(kExitFailed, arguments.file + ": " + tries.error().what);
  const LiveRun& live = tries->last;

  const LiveFigures figures = CompareFigures(live.run.metrics, simulated.metrics, arguments.bar);
  if (arguments.json) {
    const OrderedJson out = LiveJson(arguments, test, *tries, simulated, figures);
    PrintText(JsonText(out, 2));
  } else {
    PrintLive(arguments, test.name, live, simulated);
  }
  if (!arguments.keep.empty()) Say("files are in " + tries->folder.string());
  if (live.too_busy()) {
    Say("the machine was too busy in two tries: " + std::to_string(live.missed) + " of " +
        std::to_string(live.frames) + " frames came too late");
  }
  return figures.within
             ? kExitOk
             : Fail(kExitFailed, arguments.file + ": live and virtual time differ by more than " +
                                     std::to_string(std::lround(1e2 * arguments.bar)) + " %");
}

}  // namespace

void AddStabilityLive(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<LiveArguments>();
  CLI::App* command = stability.add_subcommand(
      "live",
      "Run one case with real peers over DDS in real time, and compare it with virtual time");
  command->add_option("case", arguments->file, "case file (JSON, docs/stability.md)")
      ->required()
      ->check(CLI::ExistingFile);
  command
      ->add_option("--bar", arguments->bar,
                   "allowed difference of divergence and force, as a share; exit code 1 beyond it")
      ->check(NumberAbove(0, 10))
      ->capture_default_str();
  command->add_flag(
      "--tap", arguments->tap,
      "as root: let a network of real packets make the delays, in place of the conditioner");
  command->add_option("--keep", arguments->keep,
                      "folder for recordings, hands and plans, with a sub-folder for each try");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunStabilityLive(*arguments);
  });
}

}  // namespace tandem
