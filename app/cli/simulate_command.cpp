#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/capacity/simulate_scene.h"
#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "collab/simulated/hands/hands_simulator.h"
#include "collab/simulated/network/fault_schedule.h"
#include "collab/simulated/network/light_scene.h"
#include "collab/simulated/simulator.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

struct SimulateArguments {
  std::uint64_t seeds = 100;
  std::uint64_t first = 1;
  std::uint64_t seed = 0;  // 0: many seeds
  unsigned threads = 0;    // 0: as many as processors
  std::string scene;       // scene in place of seeds
  bool hands = false;      // sessions of hands that hosts move
  double seconds = 0;      // limit for the scene or a session of hands; 0: not given
  bool hostile = false;    // one member, beside the honest ones, keeps to no rule
  bool verbose = false;
  bool json = false;
};

constexpr double kHandsSeconds = 60;
constexpr double kLeastHandsSeconds = 10;

int RunScene(const SimulateArguments& arguments) {
  const double seconds = arguments.seconds > 0 ? arguments.seconds : 1e9;
  const Result<nlohmann::ordered_json> figures = SimulateScene(arguments.scene, seconds);
  if (!figures) return Fail(kExitFile, figures.error().what);
  if (arguments.json) {
    PrintText(figures->dump(2));
  } else {
    PrintLine("%.1f times as fast as the wall clock, %.1f times in contact",
              figures->at("speed").get<double>(), figures->at("contact_speed").get<double>());
  }
  return kExitOk;
}

/// Returns how to run a single seed once more.
std::string HowToRepeat(const SimulateArguments& arguments, std::uint64_t seed) {
  std::string how = "tandem simulate";
  if (arguments.hands) how += " --hands";
  how += " --seed " + std::to_string(seed);
  char seconds[40];
  std::snprintf(seconds, sizeof seconds, " --seconds %.17g", arguments.seconds);
  if (arguments.hands && arguments.seconds > 0) how += seconds;
  return how + " --verbose";
}

/// Seeds to run.
struct SeedRange {
  std::uint64_t first = 1;
  std::uint64_t count = 1;
  unsigned threads = 1;
};

SeedRange SeedsOf(const SimulateArguments& arguments) {
  const bool one = arguments.seed != 0;
  const std::uint64_t count = one ? 1 : arguments.seeds;
  const unsigned processors = std::max(1U, std::thread::hardware_concurrency());
  const auto threads = static_cast<unsigned>(
      std::min<std::uint64_t>(count, arguments.threads == 0 ? processors : arguments.threads));
  return {.first = one ? arguments.seed : arguments.first, .count = count, .threads = threads};
}

/// Prints what a single seed stands for. Returns a function that prints what happens in its
/// session; null: nobody wants it.
SeedLog TellSeed(const SimulateArguments& arguments) {
  for (const std::string& line :
       arguments.hands ? std::vector<std::string>{} : Describe(DrawSchedule(arguments.seed))) {
    PrintLine("%s", line.c_str());
  }
  if (!arguments.verbose) return {};
  return [](const std::string& line) {
    PrintLine("%s", line.c_str());
  };
}

std::vector<SeedResult> RunRange(const SimulateArguments& arguments, const SeedRange& range,
                                 const SeedLog& log) {
  const double seconds = arguments.seconds > 0 ? arguments.seconds : kHandsSeconds;
  return arguments.hands ? SimulateHandSeeds(range.first, range.count, range.threads, seconds,
                                             MakeLightScene(), log)
                         : SimulateSeeds(range.first, range.count, range.threads, MakeLightScene(),
                                         log, arguments.hostile);
}

/// The results of all seeds together.
struct SeedTotals {
  double peer_seconds = 0;
  double session_seconds = 0;
  Tally tally;
  std::uint64_t broken = 0;
  std::uint64_t digest = 0;
  nlohmann::ordered_json found = nlohmann::ordered_json::array();
};

SeedTotals TotalsOf(const SimulateArguments& arguments, const std::vector<SeedResult>& results) {
  SeedTotals totals;
  for (const SeedResult& result : results) {
    totals.peer_seconds += result.peer_seconds;
    totals.session_seconds += result.seconds;
    totals.digest = totals.digest * 0x100000001b3U ^ result.digest;
    for (const auto& [what, times] : result.tally) totals.tally[what] += times;
    if (result.broken.empty()) continue;
    ++totals.broken;
    totals.found.push_back({{"seed", result.seed},
                            {"broken", result.broken},
                            {"repeat", HowToRepeat(arguments, result.seed)}});
  }
  return totals;
}

nlohmann::ordered_json SeedsJson(const SeedTotals& totals, const SeedRange& range, double wall_s) {
  return {{"seeds", range.count},
          {"broken", totals.broken},
          {"wall_s", wall_s},
          {"simulated_s", totals.session_seconds},
          {"simulated_peer_s", totals.peer_seconds},
          {"threads", range.threads},
          {"digest", Hex(totals.digest)},
          {"happened", totals.tally},
          {"found", totals.found}};
}

void PrintSeeds(const SimulateArguments& arguments, const std::vector<SeedResult>& results,
                const SeedTotals& totals, const SeedRange& range, double wall_s) {
  for (const auto& [what, times] : totals.tally) {
    PrintLine("%6llu %s", static_cast<unsigned long long>(times), what.c_str());
  }
  for (const SeedResult& result : results) {
    for (const std::string& line : result.broken) {
      PrintLine("seed %llu %s", static_cast<unsigned long long>(result.seed), line.c_str());
    }
    if (!result.broken.empty()) {
      PrintLine("seed %llu: repeat it with '%s'", static_cast<unsigned long long>(result.seed),
                HowToRepeat(arguments, result.seed).c_str());
    }
  }
  PrintLine(
      "%s, %llu with violations, %.1f s, %.0f s of sessions, %.0f peer-seconds simulated, digest "
      "%s",
      WithPlural(range.count, "seed").c_str(), static_cast<unsigned long long>(totals.broken),
      wall_s, totals.session_seconds, totals.peer_seconds, Hex(totals.digest).c_str());
}

int RunSimulate(const SimulateArguments& arguments) {
  if (!arguments.scene.empty()) return RunScene(arguments);
  if (arguments.seconds > 0 && !arguments.hands) {
    return Fail(kExitUsage, "--seconds is for --scene or --hands");
  }
  if (arguments.hands && arguments.seconds > 0 && arguments.seconds < kLeastHandsSeconds) {
    return Fail(kExitUsage, "--seconds: a session with --hands takes at least 10 s");
  }
  const SeedRange range = SeedsOf(arguments);
  SeedLog log;
  if (arguments.seed != 0 && !arguments.json) log = TellSeed(arguments);
  const auto began = std::chrono::steady_clock::now();
  const std::vector<SeedResult> results = RunRange(arguments, range, log);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  const SeedTotals totals = TotalsOf(arguments, results);
  if (arguments.json) {
    PrintText(JsonText(SeedsJson(totals, range, wall.count()), 2));
  } else {
    PrintSeeds(arguments, results, totals, range, wall.count());
  }
  return totals.broken == 0 ? kExitOk : kExitFailed;
}

}  // namespace

void AddSimulateCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate",
                                         "Simulate whole sessions in virtual time, with network "
                                         "cuts, crashes and pauses drawn from seeds");
  CLI::Option* one = command
                         ->add_option("--seed", arguments->seed,
                                      "run the session of this seed alone and describe it")
                         ->check(WholeNumberFrom(1, kLargestSeed));
  CLI::Option* scene = command
                           ->add_option("--scene", arguments->scene,
                                        "scene to simulate in place of drawn sessions: one session "
                                        "by its hands, and how fast it runs")
                           ->excludes(one);
  command->add_option("--seeds", arguments->seeds, "number of sessions")
      ->excludes(one)
      ->excludes(scene)
      ->capture_default_str()
      ->check(WholeNumberFrom(1, 1'000'000));
  command->add_option("--first", arguments->first, "first seed")
      ->capture_default_str()
      ->check(WholeNumberFrom(1, kLargestSeed))
      ->excludes(one);
  command
      ->add_flag(
          "--hands", arguments->hands,
          "simulate hosts that move hands through controllers, and a device, in place of scripts")
      ->excludes(scene);
  command
      ->add_option(
          "--seconds", arguments->seconds,
          "virtual length, s: with --scene at most this; with --hands exactly this, default 60")
      ->check(NumberAbove(0, 1e9));
  command
      ->add_option("--threads", arguments->threads,
                   "number of sessions at a time; default: one for each processor")
      ->check(WholeNumberFrom(1, kMostThreads));
  command
      ->add_flag(
          "--hostile", arguments->hostile,
          "add a hostile member that forges, replays and shuffles claims, events and manifests")
      ->excludes(scene)
      ->excludes("--hands");
  command->add_flag("--verbose", arguments->verbose,
                    "with --seed: print each event and each line that a user sees, as they come");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunSimulate(*arguments);
  });
}

}  // namespace tandem
