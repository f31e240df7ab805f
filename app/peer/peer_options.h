#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include <CLI/CLI.hpp>

#include "app/connection/connection_options.h"
#include "collab/coupling/coupling_law.h"
#include "collab/receive/link_conditioner.h"
#include "collab/session/messages.h"
#include "engine/haptics/goal_device.h"
#include "engine/haptics/workspace.h"
#include "engine/safety/device_limits.h"

namespace tandem {

class DeviceSpace;

/// A program tells these facts once it is in its session.
struct EnteredSession {
  PeerId peer = 0;
  std::string name;
  std::string holding;  // body in hand; empty: none
};

/// The options of `tandem peer`.
struct PeerArguments {
  std::string session;
  std::string scene;                    // empty with `scene_from_session`, until it is found
  bool scene_from_session = false;      // take the session's scene, wherever its files are
  bool accept_scene = false;            // fetch its files from a peer without asking the person
  std::uint64_t scene_limit_mb = 1024;  // most that is fetched, MB
  bool share_scene = true;              // hand the scene's files to joiners who lack them
  double share_rate_mb = 10;            // rate of scene files in MB/s, to all joiners together
  std::string role = "active";
  std::string hold;
  std::string hand;
  std::string device = "scripted";
  DeviceLimits device_most = kUsersDefault;  // user's limits for a device process
  WorkspaceOrder workspace;                  // mapping that a device begins with
  std::shared_ptr<DeviceSpace> space;        // device process and its mapping; null: not yet
  /// Called once: in the session, and with --hold once the hand has its body. Null: nobody asks.
  std::function<void(const EnteredSession&)> on_entered;
  std::stop_token stop;    // when it is requested, the peer loads no further
  bool passivity = false;  // the device process damps a port that is active
  int core = -1;           // core of the haptic thread; below 0: any
  int device_core = -1;    // core of the device process
  std::string name;
  std::string control;  // name of the controller that the peer is; empty: none
  std::uint32_t control_domain = 43;
  std::shared_ptr<GoalDevice::Orders> goals;  // from hosts that move the hand; null: hosts do not
  ConnectionOptions connection;
  std::size_t wait_for = 0;
  double wait_seconds = 60;
  double seconds = 0;  // after the hand's start; 0: until a signal comes
  LinkConditions conditions;
  std::string network;  // plan file
  std::string law = DefaultLaw()->name();
  bool lab = false;
  CouplingLimits limits;  // limits of the law
  bool gate = true;
  double publish_hz = 1000;
  double capacity = 0;             // points a frame; 0: measured
  double query_price = 0;          // points; 0: measured, or the default beside a given capacity
  int threads = 1;                 // threads that share a haptic frame's work
  std::uint64_t voxel_memory = 0;  // bytes, for voxels of fixed bodies; 0: all are in memory
  std::string report;
  std::string record;
  bool no_contact = false;
  bool require_rt = false;
  bool insist = false;     // keep the scene file's force parameters
  bool adopt_any = false;  // adopt the session's voxels, however far from the scene file's
  bool brief = false;      // say nothing of gaps at the start and of what became of bodies
  std::string alone;       // line said once where nobody is heard for some seconds; empty: none
  bool as_part = false;    // part of a command that starts several; its lines begin with its name
  bool repeats = false;    // another part says what there is to say of scene and session
};

/// Returns whether a device process has the device in hand.
inline bool HasDeviceProcess(const PeerArguments& arguments) {
  return arguments.device != "scripted" && arguments.device != "none";
}

/// Adds --scene-from-session, --accept-scene and --scene-limit-mb, in place of the option `scene`.
void AddSceneFetchOptions(CLI::App& command, CLI::Option* scene, bool& from_session, bool& accept,
                          std::uint64_t& limit_mb);

void AddPeerOptions(CLI::App& command, PeerArguments& arguments);

}  // namespace tandem
