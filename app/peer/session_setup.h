#pragma once

#include <memory>
#include <optional>

#include "app/capacity/capacity.h"
#include "app/common/stop_signal.h"
#include "app/judgement/start_gaps.h"
#include "app/peer/peer_options.h"
#include "app/process/device_process.h"
#include "app/process/device_space.h"
#include "collab/peer/peer_node.h"
#include "collab/recording/recorder.h"
#include "collab/session/early_inbox.h"
#include "collab/transfer/scene_server.h"
#include "engine/realtime/worker_pool.h"

namespace tandem {

/// The way into a session, in two phases: listen for its scene and agree with it, and only then
/// load (docs/decisions/0022-agreement.md). Listening goes on while the scene loads, so the first
/// peer of a session waits for nobody.
struct SessionSetup {
  SessionSetup() = default;
  ~SessionSetup() {
    if (space) space->Forget();  // the node owns the workspace
  }
  /// Returns the device process; null: the device is in this process.
  DeviceProcess* device() const noexcept { return space ? space->process() : nullptr; }
  SessionSetup(const SessionSetup&) = delete;
  SessionSetup& operator=(const SessionSetup&) = delete;

  PeerId id = 0;
  std::int64_t joined_ns = 0;
  EarlyInbox inbox;
  Scene scene;             // scene with the force parameters that the simulation uses
  ForceParameters own;     // force parameters of the scene file
  bool adopt_any = false;  // adopt the session's force parameters, however far they are from ours
  SceneHash hash;          // hash of the scene
  SceneManifest manifest;  // manifest that we offer
  std::optional<ForceParameters> unequal;  // the session's, where we insist on others
  std::shared_ptr<const WorldModel> model;
  StartGaps start_gaps;                 // gaps of bodies that contact pushes from the start
  std::vector<std::string> warnings;    // facts on the scene for its user, from the start
  std::unique_ptr<WorkerPool> workers;  // null: none
  std::unique_ptr<Recorder> recorder;   // null: none; outlives the node
  FrameCapacity capacity;
  std::size_t waiting = PeerInbox::kDefaultWaiting;  // most samples held back at once
  std::shared_ptr<DeviceSpace> space;  // device process; null: the device is in this process
  std::unique_ptr<PeerNode> node;
  int times_loaded = 0;                // loads after the first, for the session's force parameters
  GoalDevice* goal_device = nullptr;   // device of the node; null: the node has another kind
  std::unique_ptr<SceneServer> files;  // for joiners who lack the scene; null: they get none
  std::unique_ptr<Transport> transport;  // goes first, but for `goodbye`, which uses it
  std::optional<AtForcedEnd> goodbye;    // says goodbye at a forced end, while the scene loads, too
};

/// Comes as far as a node that hears the session and has said nothing but what it offers. Otherwise
/// it says why not. Returns the exit code or kEndedWhileLoading.
int Join(PeerArguments& arguments, SessionSetup& setup);
/// Join() returns this value where PeerArguments::stop has ended it. Nothing failed.
inline constexpr int kEndedWhileLoading = -2;

/// Returns whether a peer offered the session other force parameters before us. Then the world that
/// we have loaded is of no use, unless we insist. The number of new loads is limited, so that a
/// peer that always offers others cannot keep us out.
bool Superseded(const SessionSetup& setup);

}  // namespace tandem
