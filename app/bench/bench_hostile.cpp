#include <algorithm>
#include <csignal>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>
#include <sched.h>
#include <unistd.h>

#include "app/bench/bench_commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/process/child_processes.h"
#include "collab/dds/diagnostics/attack.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

constexpr double kSettleSeconds = 2;       // from the hand's beginning to the flood
constexpr double kPatienceSeconds = 60;    // for a peer to load
constexpr double kBackSeconds = 60;        // time in which a peer must give memory back
constexpr std::int64_t kKept = 2'000'000;  // bytes that the peer may keep

struct HostileArguments {
  double seconds = 5;
  double samples_per_s = 250'000;
  double packets_per_s = 500'000;
  std::uint32_t domain = 43;
  bool json = false;
  std::string attack;  // not empty: this process is the attacker
  std::string session;
  std::string out;
};

/// The outcome of one flood for a peer.
struct HostileRun {
  std::string name;
  std::uint64_t sent = 0;
  double sent_per_s = 0;
  std::uint64_t refused = 0;
  std::uint64_t reported = 0;          // lines that tell of refusals
  double lines_per_s = 0;              // lines of any kind during the flood
  std::int64_t memory_bytes = 0;       // largest memory, above that before the flood
  std::int64_t memory_kept_bytes = 0;  // memory after the flood, above that before it
  double memory_back_s = 0;            // time from the flood's end to that
  std::int64_t frames = 0;
  std::int64_t missed = 0;
  std::int64_t empty_frames = 0;
  std::int64_t empty_missed = 0;
};

/// Makes programs that are started during its life run on these cores alone.
class OnCores {
 public:
  explicit OnCores(const std::vector<int>& cores) {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t wanted;
    CPU_ZERO(&wanted);
    for (const int core : cores) CPU_SET(core, &wanted);
    sched_setaffinity(0, sizeof wanted, &wanted);
  }
  ~OnCores() { sched_setaffinity(0, sizeof before_, &before_); }
  OnCores(const OnCores&) = delete;
  OnCores& operator=(const OnCores&) = delete;

 private:
  cpu_set_t before_{};
};

std::vector<int> AllowedCores() {
  cpu_set_t allowed;
  sched_getaffinity(0, sizeof allowed, &allowed);
  std::vector<int> cores;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(core, &allowed)) cores.push_back(core);
  }
  return cores;
}

/// Returns the bytes of memory that a process has; 0: it has ended.
std::int64_t MemoryOf(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmRSS:", 0) == 0) return 1024 * std::stoll(line.substr(6));
  }
  return 0;
}

std::string TextOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::uint64_t LinesWith(const std::string& text, const std::string& piece) {
  std::istringstream lines(text);
  std::uint64_t count = 0;
  for (std::string line; std::getline(lines, line);) {
    count += line.find(piece) != std::string::npos ? 1U : 0U;
  }
  return count;
}

std::uint64_t SumOfCounts(const ordered_json& counts) {
  std::uint64_t sum = 0;
  for (const auto& [reason, count] : counts.items()) sum += count.get<std::uint64_t>();
  return sum;
}

/// Starts a peer that holds the peg of peg_in_slot, and that writes what it says into a file.
Result<ChildProcess> StartPeer(const std::string& session, const HostileArguments& arguments,
                               const std::filesystem::path& folder) {
  const std::filesystem::path scene = SceneFile("peg_in_slot");
  const std::filesystem::path hand = scene.parent_path() / "peg_in_slot_left.json";
  return ChildProcess::Start({"/bin/sh",
                              "-c",
                              R"(f="$1"; shift; exec "$@" >>"$f" 2>&1 </dev/null)",
                              "sh",
                              (folder / "said").string(),
                              (ProgramFolder() / "tandem").string(),
                              "peer",
                              "--session",
                              session,
                              "--domain",
                              std::to_string(arguments.domain),
                              "--interface",
                              "lo",
                              "--scene",
                              scene.string(),
                              "--hold",
                              "peg",
                              "--hand",
                              hand.string(),
                              "--name",
                              "anna",
                              "--capacity",
                              "20000",
                              "--brief",
                              "--report",
                              (folder / "report").string()});
}

/// Waits until the peer's haptic thread runs. Returns whether it does.
bool AwaitPeer(ChildProcess& peer, const std::filesystem::path& folder) {
  for (double waited = 0; waited < kPatienceSeconds && !peer.Poll(); waited += 0.02) {
    if (LinesWith(TextOf(folder / "said"), "is in session") > 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

Result<HostileRun> RunKind(Attack attack, const HostileArguments& arguments) {
  const TemporaryFolder folder;
  const std::string session =
      "hostile-" + std::to_string(getpid()) + "-" + std::to_string(std::random_device{}());
  const std::vector<int> cores = AllowedCores();
  const int shared = cores.front();
  std::optional<ChildProcess> peer;
  {
    const OnCores one({shared});
    Result<ChildProcess> started = StartPeer(session, arguments, folder.path());
    if (!started) return started.error();
    peer.emplace(*std::move(started));
  }
  if (!AwaitPeer(*peer, folder.path())) {
    return Error{"the peer did not start: " + TextOf(folder.path() / "said")};
  }
  // a loop without work runs on the same core, under the same flood, for as long
  PeriodicThread empty({.core = shared, .name = "empty"}, [](std::int64_t, std::int64_t) {
    return true;
  });
  std::this_thread::sleep_for(std::chrono::duration<double>(kSettleSeconds));

  HostileRun run{.name = NameOf(attack)};
  const std::uint64_t lines_before = LinesWith(TextOf(folder.path() / "said"), "");
  const std::int64_t before = MemoryOf(peer->pid());
  std::optional<ChildProcess> attacker;
  {
    const OnCores others(cores.size() > 1 ? std::vector<int>(cores.begin() + 1, cores.end())
                                          : cores);
    Result<ChildProcess> started = ChildProcess::Start(
        {(ProgramFolder() / "tandem").string(), "bench", "hostile", "--attack", NameOf(attack),
         "--attack-session", session, "--attack-out", (folder.path() / "sent").string(), "--domain",
         std::to_string(arguments.domain), "--seconds", std::to_string(arguments.seconds),
         "--samples-per-s", std::to_string(arguments.samples_per_s), "--packets-per-s",
         std::to_string(arguments.packets_per_s)});
    if (!started) return started.error();
    attacker.emplace(*std::move(started));
  }
  std::int64_t most = before;
  while (!attacker->Poll()) {
    most = std::max(most, MemoryOf(peer->pid()));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  const std::uint64_t lines = LinesWith(TextOf(folder.path() / "said"), "") - lines_before;
  run.lines_per_s = static_cast<double>(lines) / arguments.seconds;
  while (run.memory_back_s < kBackSeconds) {
    run.memory_kept_bytes = MemoryOf(peer->pid()) - before;
    if (run.memory_kept_bytes <= kKept) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    run.memory_back_s += 0.1;
  }
  peer->Signal(SIGTERM);
  empty.Stop();
  empty.Join();
  const std::string output = TextOf(folder.path() / "said");
  if (attacker->Poll() != kExitOk) return Error{"the attacker failed"};
  const std::optional<int> code = peer->Wait(std::chrono::seconds(20));
  if (code != kExitOk) return Error{"the peer did not end as it should: " + output};
  std::ifstream stream(folder.path() / "report");
  const ordered_json report = ordered_json::parse(stream, nullptr, false);
  if (report.is_discarded()) return Error{"the peer left no report"};

  run.sent = std::stoull(TextOf(folder.path() / "sent"));
  run.sent_per_s = static_cast<double>(run.sent) / arguments.seconds;
  run.refused = SumOfCounts(report.at("drops")) + SumOfCounts(report.at("packets_refused"));
  run.reported = LinesWith(TextOf(folder.path() / "said"), "refuse") +
                 LinesWith(TextOf(folder.path() / "said"), "ignored for a second");
  run.memory_bytes = most - before;
  run.frames = report.at("judged_frames").get<std::int64_t>();
  run.missed = report.at("judged_missed").get<std::int64_t>();
  run.empty_frames = empty.stats().frames();
  run.empty_missed = empty.stats().missed();
  return run;
}

ordered_json AsJson(const HostileRun& run) {
  return {{"name", run.name},
          {"sent", run.sent},
          {"sent_per_s", run.sent_per_s},
          {"refused", run.refused},
          {"told", run.reported},
          {"lines_per_s", run.lines_per_s},
          {"memory_bytes", run.memory_bytes},
          {"memory_kept_bytes", run.memory_kept_bytes},
          {"memory_back_s", run.memory_back_s},
          {"frames", run.frames},
          {"missed", run.missed},
          {"empty_frames", run.empty_frames},
          {"empty_missed", run.empty_missed}};
}

int RunAttack(const HostileArguments& arguments) {
  const Result<Attack> attack = AttackNamed(arguments.attack);
  if (!attack) return Fail(kExitUsage, attack.error().what);
  DdsOptions dds;
  dds.session = arguments.session;
  dds.domain = arguments.domain;
  dds.interface = "lo";
  dds.peer = std::random_device{}() | 1U;
  const FloodPlan plan{.seconds = arguments.seconds,
                       .most = 0,
                       .per_second = *attack == Attack::kPackets ? arguments.packets_per_s
                                                                 : arguments.samples_per_s};
  const Result<std::uint64_t> sent = Flood(*attack, dds, plan);
  if (!sent) return Fail(kExitNetwork, sent.error().what);
  const auto failed = WriteWholeFile(arguments.out, std::to_string(*sent));
  return failed ? Fail(kExitFile, failed->what) : kExitOk;
}

int RunBenchHostile(const HostileArguments& arguments) {
  if (!arguments.attack.empty()) return RunAttack(arguments);
  ordered_json kinds = ordered_json::array();
  for (std::size_t i = 0; i < static_cast<std::size_t>(Attack::kCount); ++i) {
    const Result<HostileRun> run = RunKind(static_cast<Attack>(i), arguments);
    if (!run) return Fail(kExitFailed, run.error().what);
    kinds.push_back(AsJson(*run));
    if (arguments.json) continue;
    std::printf(
        "%-8s %9llu sent (%.0f/s), %9llu refused, reported %llu times, %+.1f MB, kept %+.1f MB "
        "after %.1f s, missed %lld of %lld (empty loop %lld of %lld), %.1f lines/s\n",
        run->name.c_str(), static_cast<unsigned long long>(run->sent), run->sent_per_s,
        static_cast<unsigned long long>(run->refused),
        static_cast<unsigned long long>(run->reported),
        1e-6 * static_cast<double>(run->memory_bytes),
        1e-6 * static_cast<double>(run->memory_kept_bytes), run->memory_back_s,
        static_cast<long long>(run->missed), static_cast<long long>(run->frames),
        static_cast<long long>(run->empty_missed), static_cast<long long>(run->empty_frames),
        run->lines_per_s);
  }
  if (arguments.json) std::printf("%s\n", JsonText(ordered_json{{"kinds", kinds}}, 2).c_str());
  return kExitOk;
}

}  // namespace

void AddBenchHostile(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<HostileArguments>();
  CLI::App* command = bench.add_subcommand(
      "hostile",
      "Measure a peer under floods on one core, and an empty loop under the same floods");
  command->add_option("--seconds", arguments->seconds, "duration of each flood, s")
      ->check(NumberFrom(0.1, 600))
      ->capture_default_str();
  command
      ->add_option("--samples-per-s", arguments->samples_per_s,
                   "samples/s of the floods by DDS; the machine may send fewer")
      ->check(NumberFrom(1, 1e7))
      ->capture_default_str();
  command
      ->add_option("--packets-per-s", arguments->packets_per_s,
                   "packets/s of the flood by a plain socket; the machine may send fewer")
      ->check(NumberFrom(1, 1e7))
      ->capture_default_str();
  command->add_option("--domain", arguments->domain, "DDS domain, a number")
      ->check(WholeNumberFrom(0, 230))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  // these options make it the attacking process; an empty group hides them from the help
  command->add_option("--attack", arguments->attack)->group("");
  command->add_option("--attack-session", arguments->session)->group("");
  command->add_option("--attack-out", arguments->out)->group("");
  command->callback([arguments, &exit_code] {
    exit_code = RunBenchHostile(*arguments);
  });
}

}  // namespace tandem
