#include "app/peer/run_peer.h"

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/peer/peer_control.h"
#include "app/peer/peer_once.h"
#include "app/peer/peer_session.h"
#include "app/peer/run_watch.h"
#include "app/peer/session_setup.h"

namespace tandem {

namespace {

/// Looks on as tandem watch does.
int LookOn(const PeerArguments& arguments) {
  if (!arguments.hold.empty() || !arguments.hand.empty() || !arguments.record.empty()) {
    return Fail(kExitUsage, "--role viewer: a viewer neither holds nor records anything");
  }
  WatchOptions options;
  options.session = arguments.session;
  options.scene = arguments.scene;
  options.scene_from_session = arguments.scene_from_session;
  options.fetch = {.accept = arguments.accept_scene, .limit_mb = arguments.scene_limit_mb};
  options.name = arguments.name;
  options.connection = arguments.connection;
  options.seconds = arguments.seconds;
  options.report = arguments.report;
  options.on_entered = arguments.on_entered;
  return WatchCommand(options);
}

bool HoldsBytes(const std::string& file) {
  std::error_code not_there;
  return std::filesystem::is_regular_file(file, not_there) &&
         std::filesystem::file_size(file, not_there) > 0;
}

}  // namespace

int RunPeer(PeerArguments& arguments) {
  if (arguments.role == "viewer") return LookOn(arguments);  // a viewer needs no scene
  if (arguments.scene.empty() && !arguments.scene_from_session) {
    return Fail(kExitUsage, "--scene is required, or --scene-from-session (tandem peer --help)");
  }
  if (arguments.as_part) LinePrefix() = arguments.name;
  if (!arguments.record.empty() && arguments.voxel_memory > 0) {
    return Fail(kExitUsage,
                "--record: a replay has all voxels in memory, so it cannot repeat waits for them: "
                "leave --voxel-memory out");
  }
  if (HoldsBytes(arguments.record)) {
    return Fail(kExitFile, arguments.record + " exists already: recordings are never overwritten");
  }
  arguments.space = std::make_shared<DeviceSpace>(arguments.workspace);
  std::unique_ptr<PeerControl> control;
  if (!arguments.control.empty()) {
    Result<std::unique_ptr<PeerControl>> opened = PeerControl::Open(arguments);
    if (!opened) return Fail(kExitNetwork, opened.error().what);
    control = *std::move(opened);
  }
  constexpr int kMostJoins = 3;  // limit for force parameters that others offer meanwhile
  int exit_code = kJoinAgain;
  const std::string record = arguments.record;
  int joins = 0;
  for (int run = 1; exit_code == kJoinAgain; ++run, ++joins) {
    if (control && control->TakeLoad(arguments)) joins = 0;
    // each scene that a host loads has a recording of its own
    if (HoldsBytes(arguments.record)) arguments.record = record + "." + std::to_string(run);
    exit_code = RunOnce(arguments, control.get(), joins < kMostJoins);
    if (exit_code == kEndedWhileLoading) exit_code = kExitOk;
    // if a host's scene cannot be loaded, the previous one goes on
    const bool failed = exit_code != kJoinAgain && exit_code != kExitOk;
    if (failed && control && control->RevertLoad(arguments, LastMessage())) exit_code = kJoinAgain;
  }
  return exit_code;
}

}  // namespace tandem
