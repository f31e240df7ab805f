#include <array>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/bench/bench_commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/process/child_processes.h"
#include "app/process/peer_command_line.h"
#include "engine/base/text/json_text.h"

namespace tandem {
namespace {

using nlohmann::ordered_json;

constexpr double kMostLoadingSeconds = 120;

struct WindowBenchArguments {
  std::string scene = "bracket_actuator";
  double seconds = 15;
  int rounds = 2;
  bool pictures = false;
  bool json = false;
};

/// The frames of a peer in which its hand moves, over all runs of one sort.
struct PeerFrames {
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;
  std::uint64_t over_1ms = 0;
  double wall_p999_us = 0;  // worst run
  std::uint64_t pictures = 0;
  std::string scheduler;

  void Add(const ordered_json& report) {
    frames += report.at("judged_frames").get<std::uint64_t>();
    missed += report.at("judged_missed").get<std::uint64_t>();
    over_1ms += report.at("frames_over_1ms").get<std::uint64_t>();
    wall_p999_us = std::max(wall_p999_us, report.at("frame_wall_us").at("p999").get<double>());
    scheduler = report.at("scheduler").get<std::string>();
  }
  ordered_json AsJson() const {
    return {{"frames", frames},
            {"missed", missed},
            {"frames_over_1ms", over_1ms},
            {"frame_wall_p999_us", wall_p999_us}};
  }
};

Result<ordered_json> ReadReport(const std::filesystem::path& file, const std::string& whose) {
  std::ifstream stream(file);
  ordered_json report = ordered_json::parse(stream, nullptr, false);
  if (report.is_discarded()) return Error{whose + " left no report"};
  return report;
}

/// Runs a peer that is a controller and that a script moves, with a window at it or alone.
Result<bool> RunPeerOnce(const WindowBenchArguments& arguments, const Scene& scene, bool window,
                         PeerFrames& figures) {
  const TemporaryFolder folder;
  const std::string control =
      "bench-" + std::to_string(getpid()) + "-" + std::to_string(std::random_device{}());
  const LocalPeer local{.session = control,
                        .scene = scene.file,
                        .name = "bench",
                        .hand = scene.hands[0],
                        .seconds = arguments.seconds,
                        .report = folder.path() / "peer.json"};
  Result<ChildProcess> peer =
      ChildProcess::Start(CommandLineOf(local, {"--control", control, "--capacity", "20000"}));
  if (!peer) return peer.error();
  std::optional<ChildProcess> beside;
  const std::filesystem::path seen = folder.path() / "window.json";
  if (window) {
    Result<ChildProcess> started =
        ChildProcess::Start({(ProgramFolder() / "tandem-view").string(), "--attach", "--control",
                             control, "--name", "bench", "--report", seen.string()});
    if (!started) return started.error();
    beside.emplace(std::move(*started));
  }
  const std::chrono::milliseconds limit(
      static_cast<long>(1e3 * (arguments.seconds + kMostLoadingSeconds)));
  const int code = peer->Wait(limit).value_or(-1);
  if (code != kExitOk) return Error{"the peer ended with exit code " + std::to_string(code)};
  const Result<ordered_json> report = ReadReport(local.report, "the peer");
  if (!report) return report.error();
  figures.Add(*report);
  if (!beside) return true;
  beside->Signal(SIGTERM);
  const int ended = beside->Wait(std::chrono::seconds(30)).value_or(-1);
  if (ended != kExitOk) return Error{"the window ended with exit code " + std::to_string(ended)};
  const Result<ordered_json> drawn = ReadReport(seen, "the window");
  if (!drawn) return drawn.error();
  figures.pictures += drawn->at("pictures").get<std::uint64_t>();
  return true;
}

constexpr std::chrono::seconds kMostPictureTime(1800);

/// Times the pictures of a scene in a program of its own, which has the renderer.
int RunPictureBench(const WindowBenchArguments& arguments, const Scene& scene) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "pictures.json";
  Result<ChildProcess> view = ChildProcess::Start(
      {(ProgramFolder() / "tandem-view").string(), "--scene", scene.file.string(),
       "--time-pictures", file.string(), "--rounds", std::to_string(arguments.rounds)});
  if (!view) return Fail(kExitFailed, view.error().what);
  const int code = view->Wait(kMostPictureTime).value_or(-1);
  if (code != kExitOk) {
    return Fail(kExitFailed, "tandem-view ended with exit code " + std::to_string(code));
  }
  const Result<ordered_json> times = ReadReport(file, "tandem-view");
  if (!times) return Fail(kExitFailed, times.error().what);
  if (arguments.json) {
    std::printf("%s\n", JsonText(*times, 2).c_str());
    return kExitOk;
  }
  const std::string renderer = times->at("renderer").get<std::string>();
  std::printf("pictures of %s by %s, ms: the median of %d rounds\n", arguments.scene.c_str(),
              renderer.c_str(), arguments.rounds);
  std::printf("  static triangles  samples  full redraw  fixed eye  ratio (least)  moving eye\n");
  for (const ordered_json& one : times->at("pictures")) {
    const auto median = [&one](const char* key) {
      return one.at(key).at("median").get<double>();
    };
    std::printf("  %16zu  %7d  %11.1f  %9.1f  %5.1f (%5.1f)  %10.1f\n",
                one.at("static_triangles").get<std::size_t>(), one.at("samples").get<int>(),
                median("full_redraw_ms"), median("fixed_eye_ms"), median("ratio"),
                one.at("ratio").at("least").get<double>(), median("moving_eye_ms"));
  }
  return kExitOk;
}

int RunWindowBench(const WindowBenchArguments& arguments) {
  const Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  if (arguments.pictures) return RunPictureBench(arguments, *scene);
  if (scene->hands.empty()) return Fail(kExitFile, arguments.scene + ": the scene has no hands");
  PeerFrames with;
  PeerFrames without;
  for (int round = 0; round < arguments.rounds; ++round) {
    // the machine changes: both sorts of runs meet it alike
    for (const bool window : {false, true, true, false}) {
      const Result<bool> run = RunPeerOnce(arguments, *scene, window, window ? with : without);
      if (!run) return Fail(kExitFailed, run.error().what);
    }
  }
  const double picture_hz =
      static_cast<double>(with.pictures) / (2.0 * arguments.rounds * arguments.seconds);
  if (arguments.json) {
    const ordered_json json{{"scene", arguments.scene},
                            {"scheduler", with.scheduler},
                            {"with_window", with.AsJson()},
                            {"without_window", without.AsJson()},
                            {"pictures_per_second", picture_hz}};
    std::printf("%s\n", JsonText(json, 2).c_str());
    return kExitOk;
  }
  std::printf(
      "a peer of 1 kHz, %s, and a window connected to it that draws %.0f pictures a second\n",
      with.scheduler.c_str(), picture_hz);
  const std::array<std::pair<const char*, const PeerFrames*>, 2> rows{
      {{"with the window", &with}, {"without it", &without}}};
  for (const auto& [name, figures] : rows) {
    std::printf("  %-16s %llu of %llu deadlines missed, %llu frames over 1 ms, p99.9 %.1f us\n",
                name, static_cast<unsigned long long>(figures->missed),
                static_cast<unsigned long long>(figures->frames),
                static_cast<unsigned long long>(figures->over_1ms), figures->wall_p999_us);
  }
  return kExitOk;
}

}  // namespace

void AddBenchWindow(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<WindowBenchArguments>();
  CLI::App* command = bench.add_subcommand(
      "window",
      "Count the missed deadlines of a peer with and without a connected window; needs a display");
  command->add_option("--scene", arguments->scene, "scene with a hand")->capture_default_str();
  command
      ->add_option("--seconds", arguments->seconds, "duration of the hand's motion in each run, s")
      ->check(NumberFrom(1, 600))
      ->capture_default_str();
  command
      ->add_option(
          "--rounds", arguments->rounds,
          "number of rounds: two runs with the window and two without, or one of --pictures")
      ->check(WholeNumberFrom(1, 99))
      ->capture_default_str();
  command->add_flag(
      "--pictures", arguments->pictures,
      "measure the time of pictures instead: full redraws, a fixed eye, a moving eye");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunWindowBench(*arguments);
  });
}

}  // namespace tandem
