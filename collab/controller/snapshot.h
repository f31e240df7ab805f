#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "collab/controller/requests.h"

namespace tandem {

/// What a controller shows its hosts. SI units, world frame W.

/// A body of the scene, in the order of the scene file.
struct SnapshotBody {
  std::string name;
  bool fixed = false;
  bool shared = false;                 // several users may hold it at once
  bool in_hand = false;                // in this controller's hand
  PlainPose X_WB;                      // B: centre of mass, axes of the mesh file
  PlainPose X_W;                       // displacement from its first place: p_W now = X_W p_W then
  std::vector<std::uint64_t> holders;  // ids of all peers that hold it, ours included
};

/// Another user's instance of a shared body, which is where that user has it.
struct SnapshotInstance {
  std::uint64_t peer = 0;
  std::size_t body = 0;  // into `bodies`
  PlainPose X_W;
};

/// A contact of what is in hand, as of the newest frame.
struct SnapshotContact {
  std::array<double, 3> p_W{};
  std::array<double, 3> n_W{};  // away from the surface that is met
  double depth_m = 0;           // beyond where force begins
  double force_N = 0;
};

struct SnapshotPeer {
  std::uint64_t id = 0;
  std::string name;
  bool active = true;               // else a viewer
  bool here = true;                 // else it has left or fell silent
  std::string refused{};            // why it is not heard; empty: it is
  double delay_s = 0;               // one way; 0: not known
  std::vector<std::size_t> held{};  // into `bodies`
  double link_force_N = 0;          // between its hand's body and ours
};

/// The hand, of whatever device.
struct SnapshotHand {
  /// What moves it: the goals of a host, or a device at the controller.
  enum class Input : std::uint8_t { kHost, kDevice };
  enum class State : std::uint8_t { kEmpty, kAsking, kHolding, kRetracing, kStopped };
  Input input = Input::kHost;
  State state = State::kEmpty;
  std::uint64_t host = 0;  // id of the host whose goals count; 0: none
  std::int64_t body = -1;  // into `bodies`: in hand
  PlainPose X_WG;          // grasp frame, where the part has it
  PlainPose goal;          // as the host asked for
  PlainPose limited_goal;  // where the coupling pulls to: not farther ahead than the force limit
  std::array<double, 3> force_N{};    // of the hand on the part
  std::array<double, 3> torque_Nm{};  // about the grasped point
  double felt_N = 0;                  // what a device was given
};

struct SnapshotSafety {
  /// As docs/decisions/0033-safety.md has them: what the hand's device may have, and why.
  enum class State : std::uint8_t {
    kOff,
    kRamping,
    kOn,
    kDamping,
    kTooFast,
    kExpired,
    kOverrun,
    kFault,
    kSuspended,
    kStopped,
    kSilent
  };
  State state = State::kOn;
  std::uint64_t clamped = 0;  // frames, each
  std::uint64_t slewed = 0;
  std::uint64_t zeroed = 0;
  std::uint64_t expired = 0;
  std::uint64_t stops = 0;
};

/// How near the part in hand is to the others, where that is measured (MeasureDistancesRequest).
struct SnapshotDistance {
  double m = -1;       // -1: not measured
  double error_m = 0;  // it is no farther off than that
  std::int64_t other = -1;            // into `bodies`: what it is nearest to
  std::array<double, 3> p_W{};        // nearest point of the part in hand
  std::array<double, 3> p_other_W{};  // and of the other
};

struct ControllerSnapshot {
  std::uint64_t frame = 0;   // of the controller's simulation
  std::int64_t time_ns = 0;  // monotonic clock of this machine, of that frame
  std::string session;
  std::string scene;               // file
  std::uint64_t scene_number = 0;  // counts loads: bodies are others when it changes
  std::uint64_t self = 0;          // the controller's peer id
  std::vector<SnapshotBody> bodies;
  std::vector<SnapshotInstance> instances;
  SnapshotHand hand;
  std::vector<SnapshotContact> contacts;  // the 32 strongest at the most
  int contact_points = 0;                 // all of them
  SnapshotDistance distance;
  std::vector<SnapshotPeer> peers;
  SnapshotSafety safety;
  std::string news;              // the newest line that a user should read
  std::uint64_t news_count = 0;  // grows with each
};

}  // namespace tandem
