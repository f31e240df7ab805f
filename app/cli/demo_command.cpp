#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <memory>
#include <random>
#include <thread>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/judgement/demo_judgement.h"
#include "app/judgement/proximity_bodies.h"
#include "app/judgement/start_gaps.h"
#include "app/judgement/verdict.h"
#include "app/peer/text/peer_report.h"
#include "app/process/child_processes.h"
#include "app/process/peer_command_line.h"
#include "app/recording/trace_file.h"
#include "collab/coupling/coupling_law.h"
#include "engine/base/text/json_text.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

// share of a run's default length; a shorter run does not show whether it is stable
constexpr double kJudgedShare = 0.9;
constexpr double kDeepestVoxels = 0.5;  // in the fixture; a greater depth fails
constexpr double kJudgeSeconds = 60.0;
constexpr double kLeastDemoSeconds = 2;
constexpr double kMostSeconds = 600;
constexpr double kMeetingSeconds = 180.0;  // for loading and meeting, at the most
constexpr double kPictureAt = 0.28;        // share of the run at which the part is about half out

struct DemoArguments {
  std::string scene = "bracket_actuator";
  double seconds = 0;  // 0: as long as the hands need
  double delay_ms = 100;
  double jitter_ms = 0;
  double loss = 0;
  std::uint64_t seed = 1;
  std::string law = DefaultLaw()->name();
  std::string screenshot;
  bool headless = false;
  bool json = false;
  bool no_contact = false;
};

/// Returns how long a run must be, s. The hands are at rest by 60 % of it. Rest is judged by the
/// last third, which begins when the held body has had time to come to rest at this delay.
Result<double> SecondsFor(const Scene& scene, double delay_ms) {
  double hands = 0;
  for (const SceneHand& hand : scene.hands) {
    const Result<HandScript> script = LoadHandScript(hand.file);
    if (!script) return script.error();
    hands = std::max(hands, script->duration());
  }
  const double calm = 1 + 3e-3 * delay_ms;
  return std::ceil(std::max(hands / 0.6, 1.5 * (hands + calm)));
}

/// Returns why the demo cannot show the scene, and how to make one that it can; empty: it can.
std::string WhyNoDemo(const Scene& scene) {
  constexpr const char* kHow =
      ": the demo needs two hands on one body: \"hands\": [{\"body\": NAME, \"file\": HAND}, "
      "{\"body\": NAME, \"file\": HAND}] with one name twice (one file may do for both)";
  if (scene.hands.size() != 2 || scene.hands[0].body != scene.hands[1].body) {
    return scene.file.string() + kHow + "; it has " + WithPlural(scene.hands.size(), "hand") +
           (scene.hands.size() == 2 ? " on two bodies" : "");
  }
  const std::string& body = scene.hands[0].body;
  if (scene.bodies[static_cast<std::size_t>(scene.BodyNamed(body))].shared) return {};
  return scene.file.string() + ": the demo's two hands hold one body together: give '" + body +
         "' the key \"sharing\": \"shared\"";
}

bool HasDisplay() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

std::vector<std::string> PeerCommand(const DemoArguments& arguments, const Scene& scene,
                                     const std::string& session, std::size_t peer,
                                     const std::filesystem::path& report) {
  constexpr std::array<const char*, 2> kNames{"Anna", "Ben"};
  std::vector<std::string> more{"--delay-ms",  std::to_string(arguments.delay_ms),
                                "--jitter-ms", std::to_string(arguments.jitter_ms),
                                "--loss",      std::to_string(arguments.loss),
                                "--seed",      std::to_string(arguments.seed + peer),
                                "--law",       arguments.law};
  more.emplace_back("--as-part");
  if (peer > 0) more.emplace_back("--repeats");
  if (arguments.no_contact) more.emplace_back("--no-contact");
  return CommandLineOf({.session = session,
                        .scene = scene.file,
                        .name = kNames[peer],
                        .hand = scene.hands[peer],
                        .wait_for = 1,
                        .seconds = arguments.seconds,
                        .report = report},
                       more);
}

std::vector<std::string> ViewerCommand(const DemoArguments& arguments, const std::string& session,
                                       const Scene& scene, bool window,
                                       const std::filesystem::path& report) {
  std::vector<std::string> command;
  if (window) {
    command = {(ProgramFolder() / "tandem-view").string()};
    if (!arguments.screenshot.empty()) {
      // the picture shows the part on its way out; with --seconds the window stays open after the
      // picture
      command.insert(command.end(), {"--screenshot", arguments.screenshot, "--screenshot-after",
                                     std::to_string(kPictureAt * arguments.seconds), "--seconds",
                                     std::to_string(arguments.seconds + kMeetingSeconds)});
    }
  } else {
    command = {(ProgramFolder() / "tandem").string(), "watch", "--as-part"};
  }
  command.insert(command.end(),
                 {"--session", session, "--interface", "lo", "--name", "Vera", "--scene",
                  std::filesystem::absolute(scene.file).string(), "--report", report.string()});
  return command;
}

Result<ordered_json> ReadJson(const std::filesystem::path& file) {
  std::ifstream stream(file);
  ordered_json json = ordered_json::parse(stream, nullptr, false);
  if (json.is_discarded()) return Error{file.string() + ": the file holds no report"};
  return json;
}

/// Starts all programs, waits for the peers and ends the viewer. Otherwise it says what went wrong.
int RunSession(const DemoArguments& arguments, const Scene& scene,
               const std::filesystem::path& folder) {
  const std::string session =
      "demo-" + std::to_string(getpid()) + "-" + std::to_string(std::random_device{}());
  const bool window = !arguments.headless && HasDisplay();
  Result<ChildProcess> viewer =
      ChildProcess::Start(ViewerCommand(arguments, session, scene, window, folder / "viewer.json"));
  if (!viewer) return Fail(kExitFailed, viewer.error().what);
  std::vector<ChildProcess> peers;
  for (std::size_t p = 0; p < 2; ++p) {
    Result<ChildProcess> peer = ChildProcess::Start(
        PeerCommand(arguments, scene, session, p, folder / ("peer" + std::to_string(p) + ".json")));
    if (!peer) return Fail(kExitFailed, peer.error().what);
    peers.push_back(std::move(*peer));
  }
  // loading and meeting may take a minute each; one peer that fails ends the demo
  const std::chrono::milliseconds limit(
      static_cast<long>(1e3 * (arguments.seconds + kMeetingSeconds)));
  constexpr std::chrono::milliseconds kPeriod{50};
  for (auto waited = kPeriod; !peers[0].Poll() || !peers[1].Poll(); waited += kPeriod) {
    for (ChildProcess& peer : peers) {
      const std::optional<int> ended = peer.Poll();
      if (ended && *ended != kExitOk) {
        return Fail(*ended, "a peer ended with exit code " + std::to_string(*ended));
      }
    }
    if (waited > limit) return Fail(kExitFailed, "the peers did not end in time");
    std::this_thread::sleep_for(kPeriod);
  }
  viewer->Signal(SIGTERM);
  const std::optional<int> ended = viewer->Wait(std::chrono::seconds(20));
  if (const int code = ended.value_or(kExitFailed); code != kExitOk) {
    return Fail(code, "the viewer ended with exit code " + std::to_string(code));
  }
  return kExitOk;
}

std::string Percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100 * share);
  return text;
}

struct Judged {
  ordered_json json;
  std::vector<std::string> failures;  // reasons why the run is not as it must be; empty: it is
};

Result<Judged> JudgeRun(const DemoArguments& arguments, const Scene& scene,
                        const std::filesystem::path& folder) {
  const Result<std::shared_ptr<const WorldModel>> loaded = LoadCached(scene);
  if (!loaded) return loaded.error();
  const WorldModel& model = **loaded;
  const int object = scene.BodyNamed(scene.hands[0].body);
  const auto body = static_cast<std::size_t>(model.body_index[static_cast<std::size_t>(object)]);

  Judged judged;
  ordered_json peers = ordered_json::array();
  std::vector<std::vector<TraceSample>> traces;
  double delay_sum = 0;
  for (std::size_t p = 0; p < 2; ++p) {
    const std::filesystem::path file = folder / ("peer" + std::to_string(p) + ".json");
    Result<ordered_json> report = ReadJson(file);
    if (!report) return report.error();
    delay_sum += report->at("delay_ms").get<double>();
    report->erase("delay_ms");
    peers.push_back(*report);
    Result<std::vector<TraceSample>> trace = ReadTrace(file.string() + ".trace");
    if (!trace) return trace.error();
    if (trace->empty()) return Error{"a peer recorded no frame"};
    traces.push_back(std::move(*trace));
  }
  const Result<ordered_json> viewer = ReadJson(folder / "viewer.json");
  if (!viewer) return viewer.error();

  Say("judging both instances by exact geometry");
  const TraceDivergence divergence = DivergenceOf(traces[0], traces[1]);
  const Outcome first = OutcomeOf(model, body, traces[0].back().X_WB);
  const Outcome second = OutcomeOf(model, body, traces[1].back().X_WB);
  const PenetrationReport penetration = Penetration(model, body, traces, kJudgeSeconds);
  const bool out = first.out && second.out;
  const bool stable = IsAtRest(traces[0]) && IsAtRest(traces[1]);
  const double depth = penetration.max_penetration_voxels * scene.voxel_size;
  if (!out) judged.failures.emplace_back("the part did not come out");
  if (!stable) judged.failures.emplace_back("the part did not come to rest");
  if (penetration.max_penetration_voxels > kDeepestVoxels) {
    judged.failures.push_back(
        "the part " +
        DescribePenetration(depth, penetration.error_voxels * scene.voxel_size, scene.voxel_size) +
        ", in " + Percent(penetration.overlap_share()) + " of the poses judged");
  }
  const auto apart_ns = traces[1].front().time_ns - traces[0].front().time_ns;
  const auto [least_s, most_s] = HandsApart(traces[0], traces[1]);
  judged.json = {
      {"scene", scene.name},
      {"contact", !arguments.no_contact},
      {"peers", peers},
      {"delay_ms", {{"injected", arguments.delay_ms}, {"measured", 0.5 * delay_sum}}},
      {"second_hand_begins_later_ms", 1e-6 * static_cast<double>(apart_ns)},
      {"second_hand_later_ms", {{"least", 1e3 * least_s}, {"most", 1e3 * most_s}}},
      {"divergence_mm", {{"peak", 1e3 * divergence.peak}, {"last", 1e3 * divergence.last}}},
      {"viewer",
       {{"pid", viewer->at("pid")},
        {"samples", viewer->at("samples")},
        {"samples_per_s", viewer->at("samples_per_s")},
        {"age_ms_p99", viewer->at("age_ms_p99")}}},
      {"travel_mm", 500.0 * (first.travel + second.travel)},
      {"out", out},
      {"max_penetration_voxels", penetration.max_penetration_voxels},
      {"max_penetration_mm", 1e3 * depth},
      {"overlap_share", penetration.overlap_share()},
      {"poses_checked", penetration.poses_checked},
      {"poses_given", penetration.poses_given},
      {"stable", stable},
      {"failures", judged.failures}};
  return judged;
}

void Tell(const ordered_json& json) {
  const auto number = [](const ordered_json& value) {
    return value.get<double>();
  };
  for (const ordered_json& peer : json.at("peers")) {
    PrintLine(
        "%s: %.0f frames, %.0f missed, p99 %.0f us of a frame's 1000, contact in %.0f %% of "
        "frames, up to %.1f N in the hand",
        peer.at("name").get<std::string>().c_str(), number(peer.at("frames")),
        number(peer.at("missed")), number(peer.at("frame_cpu_us").at("p99")),
        100 * number(peer.at("contact_share")), number(peer.at("peak_force_N")));
  }
  PrintLine(
      "delay %.0f ms injected, %.1f ms measured; distance between the two instances up to %.1f mm, "
      "%.2f mm at the end",
      number(json.at("delay_ms").at("injected")), number(json.at("delay_ms").at("measured")),
      number(json.at("divergence_mm").at("peak")), number(json.at("divergence_mm").at("last")));
  PrintLine(
      "the part moved %.0f mm and is %s; deepest penetration %.2f voxels (%.2f mm) in %.0f poses "
      "judged",
      number(json.at("travel_mm")), json.at("out").get<bool>() ? "out" : "NOT out",
      number(json.at("max_penetration_voxels")), number(json.at("max_penetration_mm")),
      number(json.at("poses_checked")));
}

/// Sets the length of the run if none is given. Refuses a run too short to show whether it is
/// stable.
int SetLength(const Scene& scene, DemoArguments& arguments) {
  const Result<double> needed = SecondsFor(scene, arguments.delay_ms);
  if (!needed) return Fail(kExitFile, needed.error().what);
  const double least = std::max(kLeastDemoSeconds, std::ceil(kJudgedShare * *needed));
  char text[200];
  if (least > kMostSeconds) {
    std::snprintf(text, sizeof text,
                  ": its hands need a run of %.0f s at this delay, but the longest demo takes %.0f "
                  "s: shorten their scripts",
                  least, kMostSeconds);
    return Fail(kExitFile, scene.file.string() + text);
  }
  if (arguments.seconds == 0)
    arguments.seconds = std::clamp(*needed, kLeastDemoSeconds, kMostSeconds);
  if (arguments.seconds >= least) return kExitOk;
  std::snprintf(text, sizeof text,
                "--seconds %g: too short to judge stability: give %.0f or more, or leave it out",
                arguments.seconds, least);
  return Fail(kExitUsage, text);
}

int RunDemo(DemoArguments& arguments) {
  const Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  if (const std::string why = WhyNoDemo(*scene); !why.empty()) return Fail(kExitFile, why);
  if (!arguments.screenshot.empty() && arguments.headless) {
    return Fail(kExitUsage, "--screenshot needs the window, and --headless opens none");
  }
  if (!arguments.screenshot.empty() && !HasDisplay()) {
    return Fail(kExitDisplay,
                "--screenshot needs a display, and there is none: run 'xvfb-run -a ./tandem demo "
                "--screenshot FILE'");
  }
  if (const int failed = SetLength(*scene, arguments); failed != kExitOk) return failed;
  const Result<std::vector<ProximityBody>> bodies = LoadProximityBodies(*scene);
  if (!bodies) return Fail(kExitFile, bodies.error().what);
  std::vector<TriangleMesh> meshes_W;
  for (const ProximityBody& body : *bodies) meshes_W.push_back(body.mesh_W);
  StartGaps gaps;
  if (!arguments.no_contact) gaps = FindStartGaps(*scene, meshes_W);
  TellStart(gaps);

  const TemporaryFolder folder;
  if (const int failed = RunSession(arguments, *scene, folder.path()); failed != kExitOk) {
    return failed;
  }
  Result<Judged> judged = JudgeRun(arguments, *scene, folder.path());
  if (!judged) return Fail(kExitFailed, judged.error().what);
  judged->json["start_gaps"] = AsJson(gaps);
  if (arguments.json) {
    PrintText(JsonText(judged->json, 2));
  } else {
    Tell(judged->json);
  }
  if (arguments.no_contact || judged->failures.empty()) return kExitOk;
  for (const std::string& failure : judged->failures) Say(failure);
  TellStart(gaps);  // bodies too near from the start are the first thing to look at
  return kExitFailed;
}

}  // namespace

void AddDemoCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DemoArguments>();
  CLI::App* command = app.add_subcommand("demo",
                                         "Run two peers and a viewer on this machine: two hands "
                                         "hold one part and take it out together");
  command->add_option("--scene", arguments->scene,
                      "name of a scene, or a scene file with two hands on one shared body");
  command
      ->add_option("--seconds", arguments->seconds,
                   "length of the run, s; default: as long as the scene's hands need")
      ->check(NumberFrom(kLeastDemoSeconds, kMostSeconds));
  command->add_option("--delay-ms", arguments->delay_ms, "delay injected each way, ms")
      ->check(NumberFrom(0, 2000));
  command->add_option("--jitter-ms", arguments->jitter_ms, "greatest further delay, at random, ms")
      ->check(NumberFrom(0, 1000));
  command->add_option("--loss", arguments->loss, "share of samples lost, 0 to 1")
      ->check(NumberFrom(0, 1));
  command->add_option("--seed", arguments->seed, "random seed of jitter and loss")
      ->check(WholeNumberFrom(0, kLargestSeed));
  command->add_option("--law", arguments->law, "coupling law: how stiffness follows delay")
      ->check(OneOf(LawNames(false)))
      ->capture_default_str();
  command
      ->add_option("--screenshot", arguments->screenshot,
                   "picture file of the viewer's window (PNG)")
      ->check(FileEndingIn({".png"}));
  command->add_flag("--headless", arguments->headless, "open no window even if there is a display");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->add_flag("--no-contact", arguments->no_contact,
                    "switch contact off, for comparison: the part passes through everything");
  command->callback([arguments, &exit_code] {
    exit_code = RunDemo(*arguments);
  });
}

}  // namespace tandem
