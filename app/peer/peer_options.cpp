#include "app/peer/peer_options.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "app/common/option_checks.h"
#include "collab/coupling/coupling_law.h"
#include "collab/coupling/coupling_limits.h"
#include "collab/session/messages.h"
#include "engine/haptics/workspace.h"
#include "engine/realtime/worker_pool.h"

namespace tandem {

namespace {

void AddShareOptions(CLI::App& command, PeerArguments& arguments) {
  command.add_flag("!--no-share-scene", arguments.share_scene,
                   "do not send the scene's files; default: send them to a joiner that lacks them");
  command
      .add_option("--share-rate-mb", arguments.share_rate_mb,
                  "maximum rate at which this peer sends scene files, MB/s")
      ->check(NumberFrom(0.1, 1000))
      ->capture_default_str();
}

void AddHandOptions(CLI::App& command, PeerArguments& arguments) {
  command.add_option("--hold", arguments.hold, "body to take in hand at the start");
  command.add_option("--hand", arguments.hand,
                     "hand file: a script that moves the hand in place of a device");
  command
      .add_option("--device", arguments.device,
                  "scripted: a simulated hand that feels force and yields; none: no force "
                  "feedback; NAME[:OPTIONS]: a device of 'tandem devices', in a process of its own")
      ->check(CLI::Validator(
          [](const std::string& device) -> std::string {
            const std::string name = device.substr(0, device.find(':'));
            const bool is_name = !name.empty() && std::ranges::all_of(name, [](char c) {
              return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
            });
            return is_name ? "" : "'" + device + "': expected NAME[:OPTIONS]; see 'tandem devices'";
          },
          ""))
      ->capture_default_str();
  command
      .add_option("--device-force", arguments.device_most.force,
                  "maximum force that the device process gives, N")
      ->check(NumberAbove(0, kMostForAHand.force))
      ->capture_default_str();
  command
      .add_option("--device-moment", arguments.device_most.moment,
                  "maximum moment that the device process gives, N m")
      ->check(NumberAbove(0, kMostForAHand.moment))
      ->capture_default_str();
  command.add_flag(
      "--passivity", arguments.passivity,
      "passivity control: the device process damps a hand that gets more energy than it gave");
  command
      .add_option("--device-scale", arguments.workspace.scale,
                  "metres that the hand moves in the scene for each metre of the device's handle")
      ->check(NumberFrom(Workspace::kLeastScale, Workspace::kMostScale))
      ->capture_default_str();
  command
      .add_option("--recentre", arguments.workspace.recentre,
                  "share of the handle's way by which a hand far from the middle of its workspace "
                  "is led back")
      ->check(NumberFrom(0, Workspace::kMostRecentre))
      ->capture_default_str();
  command
      .add_option("--core", arguments.core,
                  "processor core of the haptic thread; 'tandem doctor' names isolated cores")
      ->check(WholeNumberFrom(0, 1023));
  command
      .add_option("--device-core", arguments.device_core, "processor core of the device process")
      ->check(WholeNumberFrom(0, 1023));
  command
      .add_option("--wait-for", arguments.wait_for,
                  "number of other peers that must hold a body (of a shared body, the same one) "
                  "before the hand starts")
      ->check(WholeNumberFrom(0, kMaxPeers - 1));
  command.add_option("--wait-seconds", arguments.wait_seconds, "longest wait for --wait-for, s")
      ->check(NumberFrom(0, kLongestRun));
  command
      .add_option("--seconds", arguments.seconds,
                  "leave this long after the hand's start, s; 0: run until a signal")
      ->check(NumberFrom(0, kLongestRun));
}

/// Reads NAME=VALUE of a law's limit.
void ReadGain(const std::string& gain, CouplingLimits& limits) {
  const std::size_t equals = gain.find('=');
  const auto limit = std::ranges::find(kLimitNames, gain.substr(0, equals), &LimitName::name);
  if (limit == kLimitNames.end()) {
    std::string names;
    for (const LimitName& known : kLimitNames) names += ' ' + std::string(known.name);
    throw CLI::ValidationError(
        "--gain", "'" + gain + "' has no known NAME; expected NAME=NUMBER with one of" + names);
  }
  double value = -1;
  const std::string text = equals == std::string::npos ? "" : gain.substr(equals + 1);
  if (!CLI::detail::lexical_cast(text, value) || !(value >= 0) || !std::isfinite(value)) {
    throw CLI::ValidationError(
        "--gain", "'" + gain + "': expected " + std::string(limit->name) + "=NUMBER, 0 or more");
  }
  limits.*limit->value = value;
}

void AddLinkOptions(CLI::App& command, PeerArguments& arguments) {
  LinkConditions& conditions = arguments.conditions;
  command.add_option("--delay-ms", conditions.delay_ms, "delay added to received samples, ms")
      ->check(NumberFrom(0, 2000));
  command
      .add_option("--jitter-ms", conditions.jitter_ms,
                  "greatest further delay of a sample, at random, ms")
      ->check(NumberFrom(0, 1000));
  command.add_option("--loss", conditions.loss, "share of samples lost, 0 to 1")
      ->check(NumberFrom(0, 1));
  command.add_option("--seed", conditions.seed, "random seed of jitter and loss")
      ->check(WholeNumberFrom(0, kLargestSeed));
  CLI::Option* network =
      command.add_option("--network", arguments.network,
                         "network plan: delay, loss and duplication per sender over time (JSON)");
  for (const char* option : {"--delay-ms", "--jitter-ms", "--loss", "--seed"}) {
    network->excludes(option);
  }
  command.add_option("--law", arguments.law, "coupling law: how stiffness follows delay")
      ->check(OneOf(LawNames(true)))
      ->capture_default_str();
  CLI::Option* lab = command.add_flag(
      "--lab", arguments.lab,
      "allow settings that can be unstable: --gain, --no-gate and the law 'constant'");
  command
      .add_option_function<std::vector<std::string>>(
          "--gain",
          [&arguments](const std::vector<std::string>& gains) {
            for (const std::string& gain : gains) ReadGain(gain, arguments.limits);
          },
          "with --lab: set a limit of the law, such as constant_stiffness=80: N/m of all links of "
          "a user together (docs/stability.md)")
      ->needs(lab);
  command
      .add_flag("!--no-gate", arguments.gate,
                "with --lab: switch the energy gates off, so that links may generate energy")
      ->needs(lab);
  command.add_option("--publish-hz", arguments.publish_hz, "rate of published states, Hz")
      ->check(NumberFrom(10, 1000));
}

void AddControlOptions(CLI::App& command, PeerArguments& arguments) {
  CLI::Option* control =
      command.add_option("--control", arguments.control,
                         "name of a controller that this peer becomes: programs on this machine "
                         "attach to it, load scenes, move the hand");
  command
      .add_option("--control-domain", arguments.control_domain,
                  "accepted for earlier command lines; it has no effect")
      ->check(WholeNumberFrom(0, kMaxDomain))
      ->needs(control)
      ->capture_default_str();
}

}  // namespace

void AddSceneFetchOptions(CLI::App& command, CLI::Option* scene, bool& from_session, bool& accept,
                          std::uint64_t& limit_mb) {
  CLI::Option* sought =
      command
          .add_flag("--scene-from-session", from_session,
                    "use the session's scene: found on this machine, or fetched from a peer")
          ->excludes(scene);
  command
      .add_flag("--accept-scene", accept, "fetch the session's scene from a peer without asking")
      ->needs(sought);
  command.add_option("--scene-limit-mb", limit_mb, "largest size of a fetched scene's files, MB")
      ->check(WholeNumberFrom(1, 65536))
      ->needs(sought)
      ->capture_default_str();
}

void AddPeerOptions(CLI::App& command, PeerArguments& arguments) {
  AddSessionOption(command, arguments.session, "name of the session to join")->required();
  CLI::Option* scene =
      command.add_option("--scene", arguments.scene, "name of a scene, or a scene file");
  AddSceneFetchOptions(command, scene, arguments.scene_from_session, arguments.accept_scene,
                       arguments.scene_limit_mb);
  AddShareOptions(command, arguments);
  command
      .add_option("--role", arguments.role,
                  "active: simulate, and hold bodies; viewer: look on, as 'tandem watch' does")
      ->check(OneOf({"active", "viewer"}))
      ->capture_default_str();
  command.add_option("--name", arguments.name, "name that others see");
  command.add_flag("--insist", arguments.insist,
                   "keep the scene file's voxels and force parameters if the session has others; "
                   "shared bodies then cannot be held");
  command.add_flag("--adopt-any", arguments.adopt_any,
                   "adopt the session's voxel size even if it differs from the scene file's by "
                   "more than a factor of 4");
  AddHandOptions(command, arguments);
  AddControlOptions(command, arguments);
  AddLinkOptions(command, arguments);
  command
      .add_option("--capacity", arguments.capacity,
                  "point tests in a frame, at most; default: as many as fit into 800 us on this "
                  "machine, adapted in the run")
      ->check(NumberAbove(0, 1e9));
  command
      .add_option("--query-price", arguments.query_price,
                  "time of an exact query at a point, in point tests; default: measured, or 400 "
                  "with --capacity")
      ->check(NumberAbove(0, 1e9));
  // earlier name of --query-price
  command.add_option("--look-price", arguments.query_price)->check(NumberAbove(0, 1e9))->group("");
  command
      .add_option("--voxel-memory", arguments.voxel_memory,
                  "memory for the fixed bodies' voxels, at most, such as 512MiB; the rest is read "
                  "as needed; plain contact only; default: all voxels stay in memory")
      ->transform(SizeInBytes());
  command
      .add_option("--threads", arguments.threads,
                  "number of threads that share a large frame's work")
      ->check(WholeNumberFrom(1, WorkerPool::kMostThreads))
      ->capture_default_str();
  AddConnectionOptions(command, arguments.connection);
  command.add_option("--report", arguments.report,
                     "report file (JSON); a trace of the first ten minutes is written beside it");
  command.add_option("--record", arguments.record,
                     "recording file: every input of every frame, for 'tandem replay'");
  command.add_flag("--no-contact", arguments.no_contact,
                   "switch contact off: bodies pass through one another");
  command.add_flag(
      "--brief", arguments.brief,
      "print neither how bodies stand at the start nor the verdict on your bodies at the end");
  // for commands that start several programs
  command.add_flag("--as-part", arguments.as_part)->group("");
  command.add_flag("--repeats", arguments.repeats)->group("");
  command.add_flag("--require-rt", arguments.require_rt,
                   "fail if the system does not grant real-time priority (SCHED_FIFO)");
}

}  // namespace tandem
