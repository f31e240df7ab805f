#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "collab/controller/requests.h"

namespace tandem {

/// Snapshots of a controller for its hosts. SI units, world frame W.

/// A body of the scene, in the order of the scene file.
struct SnapshotBody {
  std::string name;
  bool fixed = false;
  bool shared = false;                 // several users may hold it at once
  bool in_hand = false;                // in this controller's hand
  PlainPose X_WB;                      // B: centre of mass, axes of the mesh file
  PlainPose X_W;                       // displacement from its initial pose: p_W now = X_W p_W then
  std::vector<std::uint64_t> holders;  // ids of all peers that hold it, this one included
};

/// Another user's instance of a shared body, at that user's pose.
struct SnapshotInstance {
  std::uint64_t peer = 0;
  std::size_t body = 0;  // into `bodies`
  PlainPose X_W;
};

/// A contact of the part in hand, in the newest frame.
struct SnapshotContact {
  std::array<double, 3> p_W{};
  std::array<double, 3> n_W{};  // away from the surface that is touched
  double depth_m = 0;           // depth beyond the distance at which force begins
  double force_N = 0;
};

struct SnapshotPeer {
  std::uint64_t id = 0;
  std::string name;
  bool active = true;               // else a viewer
  bool here = true;                 // else it has left or fallen silent
  std::string refused{};            // why it is not taken in; empty: it is
  double delay_s = 0;               // one way; 0: not known
  std::vector<std::size_t> held{};  // into `bodies`
  double link_force_N = 0;          // force of the link between its instance and ours
  std::uint8_t colour = 0;          // number of its user's colour, 1 to 8; 0: not known
  bool stopped = false;             // its hand is in an emergency stop
};

/// The hand, moved by any device.
struct SnapshotHand {
  /// The hand's input: the goals of a host, or a device at the controller.
  enum class Input : std::uint8_t { kHost, kDevice };
  enum class State : std::uint8_t { kEmpty, kAsking, kHolding, kRetracing, kStopped };
  Input input = Input::kHost;
  State state = State::kEmpty;
  std::uint64_t host = 0;  // id of the host whose goals count; 0: none
  std::int64_t body = -1;  // into `bodies`: the part in hand
  PlainPose X_WG;          // grasp frame as the part has it
  PlainPose goal;          // the goal that the host sent
  PlainPose limited_goal;  // the goal of the coupling: no farther ahead than the force limit
  std::array<double, 3> force_N{};    // force of the hand on the part
  std::array<double, 3> torque_Nm{};  // about the grasped point
  double felt_N = 0;                  // force given to a device
};

struct SnapshotSafety {
  /// As in docs/decisions/0033-safety.md: the force that the hand's device may have, and the
  /// reason.
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
  // numbers of frames
  std::uint64_t clamped = 0;
  std::uint64_t slewed = 0;
  // numbers of times
  std::uint64_t zeroed = 0;
  std::uint64_t expired = 0;
  std::uint64_t stops = 0;
};

/// The distance of the part in hand from the others, where it is measured
/// (MeasureDistancesRequest).
struct SnapshotDistance {
  double m = -1;                      // -1: not measured
  double error_m = 0;                 // largest error of `m`
  std::int64_t other = -1;            // into `bodies`: the nearest body
  std::array<double, 3> p_W{};        // nearest point of the part in hand
  std::array<double, 3> p_other_W{};  // nearest point of that body
};

struct ControllerSnapshot {
  std::uint64_t frame = 0;   // number of the frame in the controller's simulation
  std::int64_t time_ns = 0;  // time of that frame, monotonic clock of this machine
  std::string session;
  std::string scene;               // file
  std::uint64_t scene_number = 0;  // counts loads: the bodies are others when it changes
  std::uint64_t self = 0;          // the controller's peer id
  std::vector<SnapshotBody> bodies;
  std::vector<SnapshotInstance> instances;
  SnapshotHand hand;
  std::vector<SnapshotContact> contacts;  // at most the 32 deepest
  int contact_points = 0;                 // number of all contact points
  SnapshotDistance distance;
  std::vector<SnapshotPeer> peers;
  SnapshotSafety safety;
  std::string news;              // the newest line that a user should read
  std::uint64_t news_count = 0;  // grows with each line
  /// Set where the newest line says that a peer asks for the body in hand.
  struct Asked {
    std::uint64_t peer = 0;
    std::size_t body = 0;  // into `bodies`
  };
  std::optional<Asked> asked{};
  std::uint8_t colour = 0;              // number of this user's colour, 1 to 8; 0: not known
  std::vector<std::string> warnings{};  // facts on the scene for its user, from the start
};

}  // namespace tandem
