#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/stability/cli/stability_command.h"
#include "collab/lab/run/press_run.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

constexpr std::array kMotions{PressMotion::kPress, PressMotion::kPush, PressMotion::kTap};
constexpr std::array kMirrors{MirrorModel::kHeld, MirrorModel::kDeadReckoned,
                              MirrorModel::kCompliantMirror};

struct PressArguments {
  std::vector<double> delays_ms{0, 20, 50, 100, 200, 300, 500, 1000};
  LinkConditions conditions;
  double publish_hz = 1000;
  unsigned jobs = 0;  // 0: as many as processors
  bool json = false;
};

struct Row {
  PressCase test;
  std::optional<Result<PressResult>> result;
};

std::vector<Row> RowsOf(const PressArguments& arguments) {
  std::vector<Row> rows;
  for (const PressMotion motion : kMotions) {
    for (const MirrorModel mirror : kMirrors) {
      for (const double delay_ms : arguments.delays_ms) {
        Row& row = rows.emplace_back();
        row.test.motion = motion;
        row.test.mirror = mirror;
        row.test.conditions = arguments.conditions;
        row.test.conditions.delay_ms = delay_ms;
        row.test.publish_hz = arguments.publish_hz;
      }
    }
  }
  return rows;
}

/// Runs the rows on `jobs` threads. Their number does not change the results.
void RunAll(unsigned jobs, const std::shared_ptr<const WorldModel>& model, std::vector<Row>& rows) {
  std::atomic<std::size_t> next{0};
  std::vector<std::thread> workers;
  for (unsigned job = 0; job < jobs; ++job) {
    workers.emplace_back([&] {
      for (std::size_t i = next++; i < rows.size(); i = next++) {
        rows[i].result.emplace(RunPress(rows[i].test, model));
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
}

ordered_json AsJson(const Row& row) {
  const PressResult& result = **row.result;
  return {{"motion", NameOf(row.test.motion)},
          {"mirror", NameOf(row.test.mirror)},
          {"delay_s", 1e-3 * row.test.conditions.delay_ms},
          {"calm", result.calm},
          {"unrest_mm", 1e3 * result.unrest},
          {"speed_mm_s", 1e3 * result.speed},
          {"mean_force_N", result.mean_force},
          {"force_std_N", result.force_std},
          {"touches_per_s", result.touches_per_s},
          {"peak_force_N", result.peak_force},
          {"most_overlap_mm", 1e3 * result.most_overlap},
          {"most_lag_mm", 1e3 * result.most_lag}};
}

/// Returns for each motion with each mirror the delays at which the paper's claim holds, and those
/// that refute it. The claim is that delay does not destabilise users who hold bodies of their own
/// (paper §6.1).
ordered_json ClaimOf(const std::vector<Row>& rows) {
  ordered_json claims = ordered_json::array();
  for (const Row& row : rows) {
    const char* motion = NameOf(row.test.motion);
    const char* mirror = NameOf(row.test.mirror);
    if (claims.empty() || claims.back().at("motion") != motion ||
        claims.back().at("mirror") != mirror) {
      claims.push_back({{"motion", motion},
                        {"mirror", mirror},
                        {"holds_at_s", ordered_json::array()},
                        {"refuted_at_s", ordered_json::array()}});
    }
    const char* list = (*row.result)->calm ? "holds_at_s" : "refuted_at_s";
    claims.back()[list].push_back(1e-3 * row.test.conditions.delay_ms);
  }
  return claims;
}

std::string Milliseconds(const ordered_json& delays_s) {
  std::string text;
  for (const ordered_json& delay : delays_s) {
    text += (text.empty() ? "" : ", ") + std::to_string(std::lround(1e3 * delay.get<double>()));
  }
  return text.empty() ? "none" : text + " ms";
}

void Print(const std::vector<Row>& rows, const ordered_json& claims) {
  PrintLine("%-6s %-14s %6s  %-6s %8s %8s %7s %7s %8s %8s %8s %7s", "motion", "mirror", "delay", "",
            "unrest", "speed", "force", "std", "touches", "peak", "overlap", "lag");
  PrintLine("%-6s %-14s %6s  %-6s %8s %8s %7s %7s %8s %8s %8s %7s", "", "", "ms", "", "mm", "mm/s",
            "N", "N", "1/s", "N", "mm", "mm");
  for (const Row& row : rows) {
    const PressResult& result = **row.result;
    PrintLine("%-6s %-14s %6.0f  %-6s %8.2f %8.1f %7.1f %7.1f %8.1f %8.1f %8.0f %7.0f",
              NameOf(row.test.motion), NameOf(row.test.mirror), row.test.conditions.delay_ms,
              result.calm ? "calm" : "SHAKES", 1e3 * result.unrest, 1e3 * result.speed,
              result.mean_force, result.force_std, result.touches_per_s, result.peak_force,
              1e3 * result.most_overlap, 1e3 * result.most_lag);
  }
  PrintText("\nDo users with bodies of their own come to rest under delay?");
  for (const ordered_json& claim : claims) {
    PrintLine("%-6s %-14s yes at %s; no at %s", claim.at("motion").get<std::string>().c_str(),
              claim.at("mirror").get<std::string>().c_str(),
              Milliseconds(claim.at("holds_at_s")).c_str(),
              Milliseconds(claim.at("refuted_at_s")).c_str());
  }
}

int RunStabilityPress(PressArguments arguments) {
  const Result<Scene> scene = LoadScene(SceneFile("press_blocks"));
  if (!scene) return Fail(kExitFile, scene.error().what);
  const Result<std::shared_ptr<const WorldModel>> model = LoadCached(*scene);
  if (!model) return Fail(kExitFile, model.error().what);
  std::sort(arguments.delays_ms.begin(), arguments.delays_ms.end());
  const unsigned processors = std::max(1U, std::thread::hardware_concurrency());
  std::vector<Row> rows = RowsOf(arguments);
  RunAll(arguments.jobs == 0 ? processors : arguments.jobs, *model, rows);

  ordered_json type1 = ordered_json::array();
  std::size_t shaking = 0;  // rows that shake, with the mirrors that peers use
  for (const Row& row : rows) {
    if (!*row.result) return Fail(kExitFailed, row.result->error().what);
    type1.push_back(AsJson(row));
    shaking += !(*row.result)->calm && row.test.mirror == MirrorModel::kCompliantMirror ? 1U : 0U;
  }
  const ordered_json claims = ClaimOf(rows);
  if (arguments.json) {
    const ordered_json out{{"publish_hz", arguments.publish_hz},
                           {"jitter_ms", arguments.conditions.jitter_ms},
                           {"loss", arguments.conditions.loss},
                           {"seed", arguments.conditions.seed},
                           {"rows",
                            {{{"name", "type 1: runs that shake, with the mirrors that peers use"},
                              {"bar", "= 0"},
                              {"value", shaking},
                              {"pass", shaking == 0}}}},
                           {"claim", claims},
                           {"type1", type1}};
    PrintText(JsonText(out, 2));
  } else {
    Print(rows, claims);
  }
  return shaking == 0 ? kExitOk : Fail(kExitFailed, "users shake with the mirrors that peers use");
}

}  // namespace

void AddStabilityPress(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<PressArguments>();
  CLI::App* command = stability.add_subcommand(
      "press",
      "Run two users who press, push and tap one another's bodies, with three kinds of mirror");
  command->add_option("--delays-ms", arguments->delays_ms, "one-way delays, ms, such as 0,20,100")
      ->delimiter(',')
      ->check(NumberFrom(0, 1000))
      ->capture_default_str();
  command
      ->add_option("--jitter-ms", arguments->conditions.jitter_ms,
                   "greatest further delay, at random, ms")
      ->check(NumberFrom(0, 200));
  command->add_option("--loss", arguments->conditions.loss, "share of samples lost, 0 to 1")
      ->check(NumberFrom(0, 0.9));
  command->add_option("--seed", arguments->conditions.seed, "random seed of jitter and loss")
      ->check(WholeNumberFrom(0, kLargestSeed));
  command->add_option("--publish-hz", arguments->publish_hz, "rate of published states, Hz")
      ->check(NumberFrom(10, 1000))
      ->capture_default_str();
  command
      ->add_option("--jobs", arguments->jobs,
                   "number of runs at a time; default: one for each processor")
      ->check(WholeNumberFrom(1, kMostThreads));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunStabilityPress(*arguments);
  });
}

}  // namespace tandem
