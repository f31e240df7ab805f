#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>
#include <span>
#include <thread>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/bench/bench_commands.h"
#include "app/bench/bench_viewers.h"
#include "app/bench/measure/paired_ratios.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/process/child_processes.h"
#include "app/process/peer_command_line.h"
#include "collab/session/messages.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

struct SessionArguments {
  std::string scene = "peg_in_slot";
  std::size_t peers = 8;
  double hz = 1000;
  double seconds = 10;
  std::vector<std::size_t> compare;
  std::vector<std::size_t> viewers;
  int rounds = 3;
  bool json = false;
};

constexpr double kMostMeetingSeconds = 120;  // for loading and meeting, at the most

double LoadAverage() {
  double one_minute = 0;
  return getloadavg(&one_minute, 1) == 1 ? one_minute : 0;
}

std::string NewSession() {
  return "bench-" + std::to_string(getpid()) + "-" + std::to_string(std::random_device{}());
}

/// Runs peers, each a process, that hold the hands' body, in turn by each of the hands. All are in
/// `session`, or each is in a session of its own if `session` is empty. Returns their reports, in
/// order.
Result<std::vector<ordered_json>> RunPeers(const SessionArguments& arguments, const Scene& scene,
                                           std::span<const SceneHand> hands,
                                           const std::string& session, std::size_t count) {
  const TemporaryFolder folder;
  std::vector<ChildProcess> peers;
  std::vector<std::filesystem::path> reports;
  for (std::size_t p = 0; p < count; ++p) {
    reports.push_back(folder.path() / (std::to_string(p) + ".json"));
    // an instance has a limited number of couplings: with more peers some have none, and nobody
    // waits
    const bool waits = !session.empty() && count <= kMaxLinks;
    const LocalPeer local{.session = session.empty() ? NewSession() : session,
                          .scene = scene.file,
                          .name = "peer-" + std::to_string(p),
                          .hand = hands[p % hands.size()],
                          .wait_for = waits ? count - 1 : 0,
                          .seconds = arguments.seconds,
                          .report = reports.back()};
    const std::vector<std::string> command =
        CommandLineOf(local, {"--capacity", "20000", "--publish-hz", std::to_string(arguments.hz)});
    Result<ChildProcess> peer = ChildProcess::Start(command);
    if (!peer) return peer.error();
    peers.push_back(std::move(*peer));
  }
  const std::chrono::milliseconds limit(
      static_cast<long>(1e3 * (arguments.seconds + kMostMeetingSeconds)));
  std::vector<ordered_json> read;
  for (std::size_t p = 0; p < count; ++p) {
    const int code = peers[p].Wait(limit).value_or(-1);
    if (code != kExitOk) return Error{"a peer ended with exit code " + std::to_string(code)};
    std::ifstream stream(reports[p]);
    read.push_back(ordered_json::parse(stream, nullptr, false));
    if (read.back().is_discarded()) return Error{"a peer left no report"};
  }
  return read;
}

ordered_json Delivery(const SessionArguments& arguments, const std::vector<ordered_json>& reports,
                      double load) {
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  double least = 1;
  ordered_json cpu_us = ordered_json::array();
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;
  std::uint64_t socket_dropped = 0;
  double least_said = 1;  // least share sent of what a peer was to send
  ordered_json wall_us = ordered_json::array();
  std::uint64_t judged_frames = 0;
  std::uint64_t judged_missed = 0;
  std::uint64_t over_1ms = 0;
  std::uint64_t pairs_heard = 0;
  for (const ordered_json& report : reports) {
    const ordered_json& listeners = report.at("heard");
    const ordered_json& sent_states = report.at("said");
    least_said = std::min(least_said, sent_states.at("sent").get<double>() /
                                          std::max(1.0, sent_states.at("wanted").get<double>()));
    sent += listeners.at("sent").get<std::uint64_t>();
    received += listeners.at("received").get<std::uint64_t>();
    least = std::min(least, listeners.at("least_delivered").get<double>());
    cpu_us.push_back(report.at("frame_cpu_us").at("p99"));
    frames += report.at("frames").get<std::uint64_t>();
    missed += report.at("missed").get<std::uint64_t>();
    judged_frames += report.at("judged_frames").get<std::uint64_t>();
    judged_missed += report.at("judged_missed").get<std::uint64_t>();
    wall_us.push_back(report.at("frame_wall_us").at("p999"));
    over_1ms += report.at("frames_over_1ms").get<std::uint64_t>();
    pairs_heard += listeners.at("peers").get<std::uint64_t>();
    socket_dropped += listeners.at("socket_dropped").get<std::uint64_t>();
  }
  return {{"peers", arguments.peers},
          {"hz", arguments.hz},
          {"seconds", arguments.seconds},
          {"pairs", reports.size() * (reports.size() - 1)},
          {"pairs_heard", pairs_heard},
          {"samples_sent", sent},
          {"samples_delivered", received},
          {"delivered",
           static_cast<double>(received) / static_cast<double>(std::max<std::uint64_t>(sent, 1))},
          {"least_delivered", least},
          {"least_sent", least_said},
          {"packets_dropped_at_full_sockets", socket_dropped},
          {"frames", frames},
          {"missed", missed},
          {"judged_frames", judged_frames},
          {"judged_missed", judged_missed},
          {"frames_over_1ms", over_1ms},
          {"frame_cpu_p99_us", cpu_us},
          {"frame_wall_p999_us", wall_us},
          {"scheduler", reports.front().at("scheduler")},
          {"cores", std::thread::hardware_concurrency()},
          {"load_before", load}};
}

/// The processor time of a frame at its p50 and p99, us, in each round: the largest of the peers.
/// Beside it stand the p99 of the middle and of the quickest peer. The largest of four peers
/// exceeds that of a single one without any cause in the session.
struct FrameTimes {
  std::vector<double> p50;
  std::vector<double> p99;
  std::vector<double> median_p99;
  std::vector<double> least_p99;
  std::vector<double> wall_p999;  // wall-clock time
  std::uint64_t frames = 0;       // frames of all rounds and peers in which hands move
  std::uint64_t over_1ms = 0;     // frames above 1 ms among these
  std::uint64_t missed = 0;       // deadlines missed between them

  void Add(const std::vector<ordered_json>& reports) {
    std::vector<double> halves;
    std::vector<double> tails;
    std::vector<double> walls;
    for (const ordered_json& report : reports) {
      const ordered_json& cpu = report.at("frame_cpu_us");
      halves.push_back(cpu.at("p50").get<double>());
      tails.push_back(cpu.at("p99").get<double>());
      walls.push_back(report.at("frame_wall_us").at("p999").get<double>());
      frames += report.at("judged_frames").get<std::uint64_t>();
      over_1ms += report.at("frames_over_1ms").get<std::uint64_t>();
      missed += report.at("judged_missed").get<std::uint64_t>();
    }
    wall_p999.push_back(std::ranges::max(walls));
    p50.push_back(std::ranges::max(halves));
    p99.push_back(std::ranges::max(tails));
    median_p99.push_back(MedianOf(tails));
    least_p99.push_back(std::ranges::min(tails));
  }

  /// Adds the figures that say whether frames keep their millisecond to a row of the JSON.
  void DeadlinesInto(ordered_json& row) const {
    row["frame_wall_p999_us"] = MedianOf(wall_p999);
    row["frames"] = frames;
    row["frames_over_1ms"] = over_1ms;
    row["missed"] = missed;
  }
};

/// Compares the frames of peers that all hold the body in one session with those of as many peers
/// apart, each in a session of its own. Both show what the machine makes of so many processes. All
/// have the scene's first hand, because another hand touches more or less. The medians are over
/// rounds. Each round has every number of peers both ways, so that changes on the machine meet all
/// alike.
Result<ordered_json> Compare(const SessionArguments& arguments, const Scene& scene) {
  std::vector<FrameTimes> together(arguments.compare.size());
  std::vector<FrameTimes> apart(arguments.compare.size());
  const std::span<const SceneHand> alike(scene.hands.data(), 1);
  for (int round = 0; round < arguments.rounds; ++round) {
    for (std::size_t i = 0; i < together.size(); ++i) {
      const auto in_one = RunPeers(arguments, scene, alike, NewSession(), arguments.compare[i]);
      if (!in_one) return in_one.error();
      together[i].Add(*in_one);
      const auto alone = RunPeers(arguments, scene, alike, "", arguments.compare[i]);
      if (!alone) return alone.error();
      apart[i].Add(*alone);
    }
  }
  ordered_json rows = ordered_json::array();
  for (std::size_t i = 0; i < together.size(); ++i) {
    const double p99 = MedianOf(together[i].p99);
    const double apart_p99 = MedianOf(apart[i].p99);
    const double median_p99 = MedianOf(together[i].median_p99);
    const double apart_median_p99 = MedianOf(apart[i].median_p99);
    rows.push_back({{"peers", arguments.compare[i]},
                    {"frame_cpu_p50_us", MedianOf(together[i].p50)},
                    {"frame_cpu_p99_us", p99},
                    {"ratio", p99 / MedianOf(together[0].p99)},
                    {"apart_p50_us", MedianOf(apart[i].p50)},
                    {"apart_p99_us", apart_p99},
                    {"apart_ratio", apart_p99 / MedianOf(apart[0].p99)},
                    {"ratio_to_apart", p99 / apart_p99},
                    {"least_p99_us", MedianOf(together[i].least_p99)},
                    {"median_p99_us", median_p99},
                    {"median_ratio", median_p99 / MedianOf(together[0].median_p99)},
                    {"median_ratio_to_apart", median_p99 / apart_median_p99}});
    together[i].DeadlinesInto(rows.back());
    apart[i].DeadlinesInto(rows.back()["apart"]);
  }
  return ordered_json{
      {"seconds", arguments.seconds}, {"rounds", arguments.rounds}, {"sessions", rows}};
}

/// Compares frames of two peers on half of the cores, with viewers behind a relay on the other
/// half, with those without viewers before and after. A ratio is that of one round to the mean of
/// its two runs without viewers. The median over the rounds counts, with least and most beside it.
/// The difference of the two runs without viewers is the noise of a ratio.
Result<ordered_json> Watched(const SessionArguments& arguments, const Scene& scene) {
  std::vector<std::size_t> counts{0};
  counts.insert(counts.end(), arguments.viewers.begin(), arguments.viewers.end());
  counts.push_back(0);
  std::vector<FrameTimes> times(counts.size());
  std::vector<std::uint64_t> least_pictures(counts.size(), UINT64_MAX);
  for (int round = 0; round < arguments.rounds; ++round) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const std::string session = NewSession();
      Result<ViewerProcesses> audience = ViewerProcesses::Launch(session, counts[i]);
      if (!audience) return audience.error();
      const auto reports = [&] {
        const HalfOfTheCores apart(HalfOfTheCores::Half::kFirst);
        return RunPeers(arguments, scene, scene.hands, session, 2);
      }();
      if (!reports) return reports.error();
      const Result<std::uint64_t> least = audience->End();
      if (!least) return least.error();
      least_pictures[i] = std::min(least_pictures[i], *least);
      times[i].Add(*reports);
    }
  }
  ordered_json rows = ordered_json::array();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const PairedRatios ratio = RatiosToBase(times[i].p99, times.front().p99, times.back().p99);
    rows.push_back({{"viewers", counts[i]},
                    {"least_pictures", least_pictures[i]},
                    {"frame_cpu_p50_us", MedianOf(times[i].p50)},
                    {"frame_cpu_p99_us", MedianOf(times[i].p99)},
                    {"ratio", ratio.median},
                    {"ratio_least", ratio.least},
                    {"ratio_most", ratio.most}});
    times[i].DeadlinesInto(rows.back());
  }
  return ordered_json{{"seconds", arguments.seconds},
                      {"rounds", arguments.rounds},
                      {"viewerless_ratio", RatioOfEquals(times.front().p99, times.back().p99)},
                      {"sessions", rows}};
}

/// Returns words on a row's frames and deadlines.
std::string Deadlines(const ordered_json& row) {
  char text[160];
  std::snprintf(text, sizeof text, "; wall p99.9 %.1f us, %d of %d frames over 1 ms, %d missed",
                row.at("frame_wall_p999_us").get<double>(), row.at("frames_over_1ms").get<int>(),
                row.at("frames").get<int>(), row.at("missed").get<int>());
  return text;
}

int RunBenchSession(const SessionArguments& arguments) {
  const Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  if (scene->hands.empty()) return Fail(kExitFile, arguments.scene + ": the scene has no hands");
  const double load = LoadAverage();
  ordered_json json;
  if (!arguments.viewers.empty()) {
    const Result<ordered_json> watched = Watched(arguments, *scene);
    if (!watched) return Fail(kExitFailed, watched.error().what);
    json = *watched;
    json["load_before"] = load;
  } else if (arguments.compare.empty()) {
    const auto reports = RunPeers(arguments, *scene, scene->hands, NewSession(), arguments.peers);
    if (!reports) return Fail(kExitFailed, reports.error().what);
    json = Delivery(arguments, *reports, load);
  } else {
    const Result<ordered_json> compared = Compare(arguments, *scene);
    if (!compared) return Fail(kExitFailed, compared.error().what);
    json = *compared;
    json["load_before"] = load;
  }
  if (arguments.json) {
    std::printf("%s\n", JsonText(json, 2).c_str());
  } else if (!arguments.viewers.empty()) {
    for (const ordered_json& row : json.at("sessions")) {
      std::printf(
          "%d viewers: a frame's processor time p99 %.1f us, %.2f of a run without viewers (%.2f "
          "to "
          "%.2f in %d rounds)%s\n",
          row.at("viewers").get<int>(), row.at("frame_cpu_p99_us").get<double>(),
          row.at("ratio").get<double>(), row.at("ratio_least").get<double>(),
          row.at("ratio_most").get<double>(), arguments.rounds, Deadlines(row).c_str());
    }
    std::printf("two runs without viewers: %.2f of one another\n",
                json.at("viewerless_ratio").get<double>());
  } else if (arguments.compare.empty()) {
    std::printf(
        "%zu peers at %.0f Hz: %.4f %% of %.0f samples delivered, the worst pair %.4f %%; %d of %d "
        "pairs received messages; the slowest peer sent %.2f %% of its samples; with a moving hand "
        "%d of %d frames took more than 1 ms and %d deadlines were missed\n",
        arguments.peers, arguments.hz, 100 * json.at("delivered").get<double>(),
        json.at("samples_sent").get<double>(), 100 * json.at("least_delivered").get<double>(),
        json.at("pairs_heard").get<int>(), json.at("pairs").get<int>(),
        100 * json.at("least_sent").get<double>(), json.at("frames_over_1ms").get<int>(),
        json.at("judged_frames").get<int>(), json.at("judged_missed").get<int>());
  } else {
    for (const ordered_json& row : json.at("sessions")) {
      std::printf(
          "%d peers: a frame's processor time p99 %.1f us of the peer in the middle, %.2f of the "
          "first and %.2f of as many apart; %.1f to %.1f us over the peers, the largest %.2f of "
          "the first and %.2f of as many apart%s\n",
          row.at("peers").get<int>(), row.at("median_p99_us").get<double>(),
          row.at("median_ratio").get<double>(), row.at("median_ratio_to_apart").get<double>(),
          row.at("least_p99_us").get<double>(), row.at("frame_cpu_p99_us").get<double>(),
          row.at("ratio").get<double>(), row.at("ratio_to_apart").get<double>(),
          Deadlines(row).c_str());
    }
  }
  return kExitOk;
}

}  // namespace

void AddBenchSession(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<SessionArguments>();
  CLI::App* command = bench.add_subcommand(
      "session", "Measure whole peers on this machine: samples delivered, and the time of a frame");
  command->add_option("--scene", arguments->scene, "scene with hands on a shared body")
      ->capture_default_str();
  command->add_option("--peers", arguments->peers, "number of peers that hold the shared body")
      ->check(WholeNumberFrom(2, 16))
      ->capture_default_str();
  command->add_option("--hz", arguments->hz, "rate of published states, Hz")
      ->check(NumberFrom(10, 1000))
      ->capture_default_str();
  command->add_option("--seconds", arguments->seconds, "duration of the hands' motion, s")
      ->check(NumberFrom(1, 600))
      ->capture_default_str();
  CLI::Option* viewers =
      command
          ->add_option("--viewers", arguments->viewers,
                       "instead, measure a frame's processor time in two peers with this many "
                       "viewers behind a relay, such as 8,32, and twice with none")
          ->delimiter(',')
          ->check(WholeNumberFrom(1, 64));
  command
      ->add_option("--compare", arguments->compare,
                   "instead, measure a frame's processor time with this many peers that hold the "
                   "body, such as 1,2,4: in one session, and each in its own")
      ->delimiter(',')
      ->check(WholeNumberFrom(1, 16))
      ->excludes(viewers);
  command
      ->add_option("--rounds", arguments->rounds,
                   "number of rounds of --compare and --viewers; medians count")
      ->check(WholeNumberFrom(1, 99))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunBenchSession(*arguments);
  });
}

}  // namespace tandem
