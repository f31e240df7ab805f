#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/bench_scene.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/process/child_processes.h"
#include "app/process/peer_command_line.h"
#include "collab/controller/controller.h"
#include "engine/base/text/json_text.h"
#include "engine/base/units.h"

namespace tandem {
namespace {

using nlohmann::ordered_json;

constexpr double kMostSeconds = 120;
constexpr std::chrono::milliseconds kLookAgain(5);
constexpr double kLift = 0.2;         // m/s, speed of the goal
constexpr double kFeltForce_N = 0.5;  // force that a person takes for contact
constexpr double kHighestLift_m = 0.2;

struct OpeningArguments {
  std::string scene = "bracket_actuator";
  int rounds = 5;
  bool json = false;
};

/// The seconds from the start of a program to three events.
struct Opening {
  double answers_s = 0;  // until the program's controller answers
  double holds_s = 0;    // until the part is in the hand
  double feels_s = 0;    // until the lifted part meets something and the hand feels it
};

double SecondsSince(std::int64_t start_ns) {
  return ToSeconds(MonotonicNowNs() - start_ns);
}

Result<Controller> AttachTo(const std::string& control, std::int64_t start_ns,
                            ChildProcess& program) {
  Controller::Options options;
  options.host = "bench";
  options.timeout_s = 0.1;
  for (;;) {
    Result<Controller> found = Controller::Attach(control, options);
    if (found) return found;
    if (program.Poll()) return Error{"the program ended before its controller answered"};
    if (SecondsSince(start_ns) > kMostSeconds) return found.error();
  }
}

/// Lifts the part in hand until it meets something. Returns whether it does.
bool FeelsContact(Controller& controller) {
  const SnapshotHand& hand = controller.snapshot().hand;
  const PlainPose from = hand.X_WG;
  const std::int64_t began_ns = MonotonicNowNs();
  for (;;) {
    const double lift = kLift * SecondsSince(began_ns);
    PlainPose goal = from;
    goal.p_W[2] += std::min(lift, kHighestLift_m);
    controller.SetGoal(goal);
    controller.Wait(kLookAgain);
    controller.Poll();
    const ControllerSnapshot& now = controller.snapshot();
    if (now.contact_points > 0 && std::abs(now.hand.force_N[2]) > kFeltForce_N) return true;
    if (lift > 10 * kHighestLift_m) return false;
  }
}

/// Starts the program, takes the part and lifts it.
Result<Opening> Open(const std::vector<std::string>& words, const std::string& control,
                     const std::string& body) {
  Opening times;
  const std::int64_t start_ns = MonotonicNowNs();
  Result<ChildProcess> program = ChildProcess::Start(words);
  if (!program) return program.error();
  // a window's controller is called by the number of its process
  Result<Controller> controller = AttachTo(
      control.empty() ? "window-" + std::to_string(program->pid()) : control, start_ns, *program);
  if (!controller) return controller.error();
  times.answers_s = SecondsSince(start_ns);
  // the controller refuses while it loads the scene
  for (;;) {
    const Answer grabbed = controller->Ask(GrabRequest{.body = body});
    if (grabbed.ok) break;
    if (SecondsSince(start_ns) > kMostSeconds) {
      return Error{"the part " + body + " cannot be taken in hand: " + grabbed.reason};
    }
    controller->Wait(kLookAgain);
  }
  while (controller->snapshot().hand.state != SnapshotHand::State::kHolding) {
    if (SecondsSince(start_ns) > kMostSeconds) return Error{"the part never came into the hand"};
    controller->Wait(kLookAgain);
  }
  times.holds_s = SecondsSince(start_ns);
  if (!FeelsContact(*controller)) return Error{"the part " + body + " touches nothing when lifted"};
  times.feels_s = SecondsSince(start_ns);
  controller->Send(QuitRequest{});
  program->Signal(SIGTERM);
  program->Wait(std::chrono::seconds(30));
  return times;
}

/// Returns the median and the worst of all rounds.
ordered_json Figures(const std::vector<Opening>& rounds, double Opening::*which) {
  std::vector<double> values;
  for (const Opening& one : rounds) values.push_back(one.*which);
  return {{"median", Median(values)}, {"worst", *std::max_element(values.begin(), values.end())}};
}

ordered_json AsJson(const std::vector<Opening>& rounds) {
  return {{"answers_s", Figures(rounds, &Opening::answers_s)},
          {"holds_s", Figures(rounds, &Opening::holds_s)},
          {"feels_s", Figures(rounds, &Opening::feels_s)}};
}

int RunOpeningBench(const OpeningArguments& arguments) {
  const Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  if (scene->hands.empty()) return Fail(kExitFile, arguments.scene + ": the scene has no hands");
  const std::string& body = scene->hands[0].body;
  const TemporaryFolder folder;
  const std::string control = "bench-opening-" + std::to_string(getpid());
  LocalPeer alone;
  alone.session = control;
  alone.scene = scene->file;
  alone.name = "bench";
  alone.report = folder.path() / "peer.json";
  const std::vector<std::string> without = CommandLineOf(alone, {"--control", control});
  const std::vector<std::string> with{(ProgramFolder() / "tandem").string(), "open",
                                      scene->file.string(), "--name", "bench"};
  std::vector<Opening> windows;
  std::vector<Opening> controllers;
  for (int round = 0; round < arguments.rounds; ++round) {
    const Result<Opening> window = Open(with, "", body);
    if (!window) return Fail(kExitFailed, "the window: " + window.error().what);
    const Result<Opening> controller = Open(without, control, body);
    if (!controller) return Fail(kExitFailed, "the controller: " + controller.error().what);
    windows.push_back(*window);
    controllers.push_back(*controller);
  }
  const ordered_json json{{"scene", arguments.scene},
                          {"rounds", arguments.rounds},
                          {"window", AsJson(windows)},
                          {"controller_alone", AsJson(controllers)}};
  if (arguments.json) {
    std::printf("%s\n", JsonText(json, 2).c_str());
    return kExitOk;
  }
  std::printf("s from the start of the program, %d rounds: median (worst)\n", arguments.rounds);
  std::printf("  %-18s %-15s %-15s %s\n", "", "it answers", "part in hand", "contact felt");
  for (const auto& [which, name] :
       {std::pair{"window", "a window"}, std::pair{"controller_alone", "a controller alone"}}) {
    std::printf("  %-18s", name);
    for (const char* what : {"answers_s", "holds_s", "feels_s"}) {
      const ordered_json& one = json.at(which).at(what);
      std::printf(" %5.2f (%5.2f)  ", one.at("median").get<double>(),
                  one.at("worst").get<double>());
    }
    std::printf("\n");
  }
  return kExitOk;
}

}  // namespace

void AddBenchOpening(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<OpeningArguments>();
  CLI::App* command = bench.add_subcommand("opening",
                                           "Measure the time from the start of a window, and of a "
                                           "controller alone, to contact; needs a display");
  command
      ->add_option("--scene", arguments->scene,
                   "scene whose first hand lifts its part until it touches")
      ->capture_default_str();
  command
      ->add_option("--rounds", arguments->rounds,
                   "number of rounds, each with one window and one controller alone")
      ->check(WholeNumberFrom(1, 99))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunOpeningBench(*arguments);
  });
}

}  // namespace tandem
