#include "app/peer/peer_options.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "app/common/option_checks.h"
#include "collab/coupling/coupling_limits.h"
#include "collab/session/messages.h"
#include "engine/haptics/workspace.h"
#include "engine/realtime/frame_helpers.h"

namespace tandem {

namespace {

void AddShareOptions(CLI::App& command, PeerArguments& arguments) {
  command.add_flag("!--no-share-scene", arguments.share_scene,
                   "hand the scene's files to nobody; otherwise a joiner who lacks them gets them");
  command
      .add_option("--share-rate-mb", arguments.share_rate_mb,
                  "MB a second of these files that are sent at the most")
      ->check(NumberFrom(0.1, 1000))
      ->capture_default_str();
}

void AddHandOptions(CLI::App& command, PeerArguments& arguments) {
  command.add_option("--hold", arguments.hold, "body to take in hand");
  command.add_option("--hand", arguments.hand, "hand file: a script in place of a device");
  command
      .add_option("--device", arguments.device,
                  "scripted: a hand that feels and gives way; none: without force feedback; "
                  "NAME[:OPTIONS] of 'tandem devices': a device in a process of its own")
      ->check(CLI::Validator(
          [](const std::string& device) -> std::string {
            const std::string name = device.substr(0, device.find(':'));
            const bool is_name = !name.empty() && std::ranges::all_of(name, [](char c) {
              return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
            });
            return is_name ? ""
                           : "'" + device + "': NAME[:OPTIONS] is wanted; see 'tandem devices'";
          },
          ""))
      ->capture_default_str();
  command
      .add_option("--device-force", arguments.device_most.force,
                  "N that a device process gives at the most, whatever the device can")
      ->check(NumberAbove(0, kMostForAHand.force))
      ->capture_default_str();
  command.add_option("--device-moment", arguments.device_most.moment, "N m, likewise")
      ->check(NumberAbove(0, kMostForAHand.moment))
      ->capture_default_str();
  command.add_flag("--passivity", arguments.passivity,
                   "a device process damps a hand that gets more energy than it gave");
  command
      .add_option("--device-scale", arguments.workspace.scale,
                  "metres that the hand moves in the scene for each metre of a device process's handle")
      ->check(NumberFrom(Workspace::kLeastScale, Workspace::kMostScale))
      ->capture_default_str();
  command
      .add_option("--recentre", arguments.workspace.recentre,
                  "share of its way by which a hand far from the middle of its device is led back")
      ->check(NumberFrom(0, Workspace::kMostRecentre))
      ->capture_default_str();
  command
      .add_option("--core", arguments.core,
                  "processor core that the haptic thread keeps to; 'tandem doctor' names isolated "
                  "ones")
      ->check(WholeNumberFrom(0, 1023));
  command.add_option("--device-core", arguments.device_core, "the same for the device process")
      ->check(WholeNumberFrom(0, 1023));
  command
      .add_option("--wait-for", arguments.wait_for,
                  "the hand starts when that many others hold a body, of a shared one the same")
      ->check(WholeNumberFrom(0, kMaxPeers - 1));
  command.add_option("--wait-seconds", arguments.wait_seconds, "give up waiting after this")
      ->check(NumberFrom(0, kLongestRun));
  command
      .add_option("--seconds", arguments.seconds,
                  "leave so long after the hand's start; 0: on a signal")
      ->check(NumberFrom(0, kLongestRun));
}

/// Reads NAME=VALUE of a law's limit.
void ReadGain(const std::string& gain, CouplingLimits& limits) {
  const std::size_t equals = gain.find('=');
  const auto limit = std::ranges::find(kLimitNames, gain.substr(0, equals), &LimitName::name);
  if (limit == kLimitNames.end()) {
    std::string names;
    for (const LimitName& known : kLimitNames) names += ' ' + std::string(known.name);
    throw CLI::ValidationError("--gain", "'" + gain + "' begins with none of" + names);
  }
  double value = -1;
  const std::string text = equals == std::string::npos ? "" : gain.substr(equals + 1);
  if (!CLI::detail::lexical_cast(text, value) || !(value >= 0) || !std::isfinite(value)) {
    throw CLI::ValidationError(
        "--gain", "'" + gain + "': expected " + std::string(limit->name) + "=NUMBER, from 0 on");
  }
  limits.*limit->value = value;
}

void AddLinkOptions(CLI::App& command, PeerArguments& arguments) {
  LinkConditions& conditions = arguments.conditions;
  command.add_option("--delay-ms", conditions.delay_ms, "delay injected in what is heard")
      ->check(NumberFrom(0, 2000));
  command.add_option("--jitter-ms", conditions.jitter_ms, "up to so much more, at random")
      ->check(NumberFrom(0, 1000));
  command.add_option("--loss", conditions.loss, "share of samples lost, 0 to 1")
      ->check(NumberFrom(0, 1));
  command.add_option("--seed", conditions.seed, "of jitter and loss")
      ->check(WholeNumberFrom(0, kLargestSeed));
  CLI::Option* network =
      command.add_option("--network", arguments.network,
                         "plan file: what is heard of whom comes late, twice or not at all, and "
                         "when");
  for (const char* option : {"--delay-ms", "--jitter-ms", "--loss", "--seed"}) {
    network->excludes(option);
  }
  command.add_option("--law", arguments.law, "how stiffness follows delay")
      ->check(OneOf({"p+dd", "p+d", "linear", "pdopt", "constant"}))
      ->capture_default_str();
  CLI::Option* lab = command.add_flag("--lab", arguments.lab,
                                      "allow what can shake: see the next two, 'constant'");
  command
      .add_option_function<std::vector<std::string>>(
          "--gain",
          [&arguments](const std::vector<std::string>& gains) {
            for (const std::string& gain : gains) ReadGain(gain, arguments.limits);
          },
          "with --lab: a limit of the law, as constant_stiffness=80: N/m of all links of a user "
          "together (docs/stability.md)")
      ->needs(lab);
  command.add_flag("!--no-gate", arguments.gate, "with --lab: links may generate energy")
      ->needs(lab);
  command.add_option("--publish-hz", arguments.publish_hz, "rate of states sent")
      ->check(NumberFrom(10, 1000));
}

void AddControlOptions(CLI::App& command, PeerArguments& arguments) {
  CLI::Option* control = command.add_option(
      "--control", arguments.control,
      "be the controller of that name: programs on this machine attach to it, load scenes, move "
      "the hand");
  command
      .add_option("--control-domain", arguments.control_domain,
                  "DDS domain of that interface, on loopback")
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
                    "go by the session's scene: from this machine, or fetched from a peer")
          ->excludes(scene);
  command
      .add_flag("--accept-scene", accept, "fetch the session's scene from a peer without asking")
      ->needs(sought);
  command.add_option("--scene-limit-mb", limit_mb, "MB of files that a fetched scene may have")
      ->check(WholeNumberFrom(1, 65536))
      ->needs(sought)
      ->capture_default_str();
}

void AddPeerOptions(CLI::App& command, PeerArguments& arguments) {
  AddSessionOption(command, arguments.session, "name of the session to join")->required();
  CLI::Option* scene =
      command.add_option("--scene", arguments.scene, "scene by name, or a scene file");
  AddSceneFetchOptions(command, scene, arguments.scene_from_session, arguments.accept_scene,
                       arguments.scene_limit_mb);
  AddShareOptions(command, arguments);
  command
      .add_option("--role", arguments.role,
                  "active: simulates and may hold bodies; viewer: looks on, as tandem watch")
      ->check(OneOf({"active", "viewer"}))
      ->capture_default_str();
  command.add_option("--name", arguments.name, "how others see you");
  command.add_flag("--insist", arguments.insist,
                   "keep to the scene file's voxels and force parameters where the session has "
                   "others; shared bodies are then not held");
  command.add_flag(
      "--adopt-any", arguments.adopt_any,
      "take the session's voxels also where they are more than 4 times smaller or larger "
      "than the scene file's");
  AddHandOptions(command, arguments);
  AddControlOptions(command, arguments);
  AddLinkOptions(command, arguments);
  command
      .add_option("--capacity", arguments.capacity,
                  "points that may be tested in a frame; default: what fits 800 us here, as frames "
                  "turn out")
      ->check(NumberAbove(0, 1e9));
  command
      .add_option("--look-price", arguments.look_price,
                  "points whose test takes as long as an exact look at one; default: measured, or "
                  "400 beside --capacity")
      ->check(NumberAbove(0, 1e9));
  command
      .add_option("--voxel-memory", arguments.voxel_memory,
                  "most memory for the fixed bodies' voxels, such as 512MiB: the rest is read as "
                  "it is needed; needs the plain contact model; default: all are in memory")
      ->transform(SizeInBytes());
  command.add_option("--threads", arguments.threads, "threads that share a large frame's work")
      ->check(WholeNumberFrom(1, FrameHelpers::kMostThreads))
      ->capture_default_str();
  AddReachOptions(command, arguments.reach);
  command.add_option("--report", arguments.report,
                     "write a report (JSON) there, and a trace of the first ten minutes beside it");
  command.add_option("--record", arguments.record,
                     "keep every input of every frame there, for 'tandem replay'");
  command.add_flag("--no-contact", arguments.no_contact, "bodies pass through one another");
  command.add_flag("--brief", arguments.brief,
                   "say neither how bodies stand at the start nor what became of yours");
  // for commands that start several programs
  command.add_flag("--as-part", arguments.as_part)->group("");
  command.add_flag("--repeats", arguments.repeats)->group("");
  command.add_flag("--require-rt", arguments.require_rt, "fail when SCHED_FIFO is not granted");
}

}  // namespace tandem
