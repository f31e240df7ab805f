#include "app/stability/live/live_run.h"

#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "app/process/child_processes.h"
#include "app/process/peer_command_line.h"
#include "app/stability/live/case_peers.h"
#include "app/stability/live/tap_hub.h"
#include "collab/lab/case/case_parts.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr double kLiveMeetingSeconds = 60;  // for loading and meeting, at the most

double SecondsOf(const LabCase& test) {
  return test.seconds > 0 ? test.seconds : test.DefaultDuration();
}

std::vector<std::string> CommandOf(const LabCase& test, const LabScene& scene,
                                   const std::string& session, std::size_t user,
                                   const fs::path& folder, const TapHub* hub) {
  const std::string name = NameOfUser(user);
  const Scene& file = scene.model->scene;
  const LocalPeer peer{.session = session,
                       .scene = file.file,
                       .name = name,
                       .hand = SceneHand{.body = file.bodies[scene.object].name,
                                         .file = folder / (name + ".hand.json")},
                       .wait_for = test.users - 1,
                       .seconds = SecondsOf(test) + 2.0 * LongestDelay(test) + 0.5,
                       .report = folder / (name + ".report.json"),
                       .interface = hub == nullptr ? "lo" : TapHub::kInterface};
  std::vector<std::string> more{"--record", folder / (name + ".recording"), "--capacity",
                                std::to_string(kDefaultCapacity)};
  const std::vector<std::string> law = LawArguments(test);
  more.insert(more.end(), law.begin(), law.end());
  if (hub != nullptr) return hub->At(user, CommandLineOf(peer, more));
  more.insert(more.end(), {"--network", folder / (name + ".plan.json")});
  return CommandLineOf(peer, more);
}

/// Waits until all peers have ended well. A peer that has not ended well ends the wait.
std::optional<Error> WaitFor(std::vector<ChildProcess>& peers, double seconds) {
  constexpr std::chrono::milliseconds kPeriod{50};
  const auto limit = std::chrono::milliseconds(static_cast<long>(1e3 * seconds));
  for (auto waited = kPeriod; waited < limit; waited += kPeriod) {
    bool running = false;
    for (ChildProcess& peer : peers) {
      const std::optional<int> code = peer.Poll();
      if (code && *code != kExitOk) {
        return Error{"a peer ended with exit code " + std::to_string(*code)};
      }
      running = running || !code;
    }
    if (!running) return std::nullopt;
    std::this_thread::sleep_for(kPeriod);
  }
  return Error{"the peers did not end in time"};
}

}  // namespace

Result<LiveRun> RunLive(const LabCase& test, const LabScene& scene, const fs::path& folder,
                        bool tap) {
  std::unique_ptr<TapHub> hub;
  if (tap) {
    auto opened = TapHub::Open(test.users, [&test](std::size_t from, std::size_t to) {
      return ConditionsOf(test, from, to, test.delay_s);
    });
    if (!opened) return opened.error();
    hub = *std::move(opened);
  }
  const std::string session =
      "live-" + std::to_string(getpid()) + "-" + std::to_string(std::random_device{}());
  for (std::size_t user = 0; user < test.users; ++user) {
    const fs::path hand = folder / (NameOfUser(user) + ".hand.json");
    if (const auto fault = WriteCaseHand(test, user, hand)) return *fault;
    const fs::path plan = folder / (NameOfUser(user) + ".plan.json");
    if (const auto fault = WriteCasePlan(test, user, plan)) return *fault;
  }

  std::vector<ChildProcess> peers;
  for (std::size_t user = 0; user < test.users; ++user) {
    Result<ChildProcess> peer =
        ChildProcess::Start(CommandOf(test, scene, session, user, folder, hub.get()));
    if (!peer) return peer.error();
    peers.push_back(*std::move(peer));
  }
  if (const auto fault = WaitFor(peers, SecondsOf(test) + kLiveMeetingSeconds)) return *fault;

  LiveRun live;
  std::vector<fs::path> recordings;
  for (std::size_t user = 0; user < test.users; ++user) {
    recordings.push_back(folder / (NameOfUser(user) + ".recording"));
    std::ifstream stream(folder / (NameOfUser(user) + ".report.json"));
    const OrderedJson report = OrderedJson::parse(stream, nullptr, false);
    if (report.is_discarded()) return Error{NameOfUser(user) + " left no report"};
    live.frames += report.at("frames").get<std::uint64_t>();
    live.missed += report.at("missed").get<std::uint64_t>();
    live.scheduler = report.at("scheduler");
  }
  kHapticThread.Enter();
  Result<RecordedRun> run = MeterRecordings(recordings, test, scene);
  if (!run) return run.error();
  live.run = *run;
  return live;
}

Result<LiveTries> TryLive(const fs::path& keep, const LiveTry& run) {
  LiveTries tries;
  do {
    ++tries.count;
    const TemporaryFolder own;
    tries.folder = keep.empty() ? own.path() : keep / ("try-" + std::to_string(tries.count));
    // a folder that cannot be made cannot be written to either, which is told then
    std::error_code ignored;
    fs::create_directories(tries.folder, ignored);
    Result<LiveRun> live = run(tries.folder);
    if (!live) return live.error();
    tries.last = *std::move(live);
  } while (tries.count < 2 && tries.last.too_busy());
  return tries;
}

}  // namespace tandem
