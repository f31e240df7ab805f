#pragma once

#include <memory>
#include <optional>

#include "app/cli/capacity.h"
#include "app/cli/device_process.h"
#include "app/cli/device_space.h"
#include "app/cli/peer_options.h"
#include "app/cli/start_gaps.h"
#include "app/stop_signal.h"
#include "collab/early_inbox.h"
#include "collab/peer_node.h"
#include "collab/recording/recorder.h"
#include "collab/transfer/scene_server.h"
#include "engine/realtime/frame_helpers.h"

namespace tandem {

/// The way into a session, in two phases: listen for its scene, agree with it, and only then load
/// (docs/decisions/0022-agreement.md). Listening goes on while loading, so the first of a session
/// waits for nobody.
struct Joining {
  Joining() = default;
  ~Joining() {
    if (space) space->Forget();  // the workspace is the node's
  }
  /// Null: the device is in this process.
  DeviceProcess* device() const noexcept { return space ? space->process() : nullptr; }
  Joining(const Joining&) = delete;
  Joining& operator=(const Joining&) = delete;

  PeerId id = 0;
  std::int64_t joined_ns = 0;
  EarlyInbox inbox;
  Scene scene;                             // with the force parameters that it will be simulated by
  ForceParameters own;                     // the scene file's
  bool adopt_any = false;                  // the session's, however far they are from ours
  SceneHash hash;                          // of the scene
  SceneManifest manifest;                  // what we offer
  std::optional<ForceParameters> unequal;  // the session's, where we insist on others
  std::shared_ptr<const WorldModel> model;
  StartGaps start_gaps;                   // of bodies that contact begins on at once
  std::unique_ptr<FrameHelpers> helpers;  // null: none
  std::unique_ptr<Recorder> recorder;     // null: none; outlives the node
  FrameCapacity capacity;
  std::size_t waiting = PeerInbox::kDefaultWaiting;  // samples under way at the most
  std::shared_ptr<DeviceSpace> space;  // of the device's process; null: it is in this one
  std::unique_ptr<PeerNode> node;
  int times_loaded = 0;                  // for the session's force parameters
  GoalDevice* goal_device = nullptr;     // the node's; null: it has another kind
  std::unique_ptr<SceneServer> files;    // for joiners who lack the scene; null: they get none
  std::unique_ptr<Transport> transport;  // goes first but for what says goodbye by it
  std::optional<AtForcedEnd> goodbye;    // while it loads, too
};

/// Comes as far as a node that hears the session and has said nothing but what it offers; or says
/// why not and gives the exit code.
int Join(PeerArguments& arguments, Joining& joining);
/// Join() returns it, beside exit codes, where PeerArguments::stop has ended it: nothing failed.
inline constexpr int kEndedWhileLoading = -2;

/// Whether others have offered the session other force parameters before us: then what we have
/// loaded is of no use, unless we insist. Loading anew is done a few times at the most, lest
/// somebody who offers others for ever keeps us out.
bool Superseded(const Joining& joining);

}  // namespace tandem
