#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contact/schedule/schedule.h"
#include "engine/dynamics/virtual_coupling.h"

namespace tandem {

inline constexpr double kFrame = 1e-3;  // s
inline constexpr std::size_t kMaxLinkAnchors = 8;
/// Point tests in a frame of 1 ms, on slow processors too.
inline constexpr double kDefaultCapacity = 1e5;
inline constexpr double kDefaultQueryPrice = 400;

/// The source of an instance's motion in a frame.
enum class BodyDrive : std::uint8_t {
  kInactive,   // nothing: it takes no part, so it neither pushes nor is pushed
  kParked,     // nothing: it stands
  kSimulated,  // forces, at this peer
  kMirrored,   // another peer, whose pose it follows
  kCompliant   // another peer, to whose pose it is pulled: it gives way where it is pushed
};

/// All external inputs of a frame. Sized once, for all instances of a world: see ParkedInputs().
struct StepInputs {
  struct InstanceInput {
    BodyDrive drive = BodyDrive::kInactive;
    Pose mirror_WB;      // pose that a mirrored or yielding instance goes to
    Twist begin_V_WB;    // first twist of a mirrored instance that becomes simulated
    CouplingGains pull;  // for a yielding one: springs to that pose, dampers against the ground
  };
  struct Hand {
    int body = -1;  // body whose first instance it holds; -1: the hand holds nothing
    Pose X_BD;      // grasp
    Anchor goal;    // the device
    CouplingGains gains;
  };
  /// The clearance of the body in hand from other bodies' surfaces (paper §3.2); all other bodies
  /// keep to the scene's.
  struct HandClearance {
    static constexpr int kSceneLayer = -1;
    int force_layer = kSceneLayer;
    double displacement = 0;  // shift along the inward normals of the pointshells of its pairs, m
  };
  struct Link {
    Anchor copy;  // another user's instance of the held body
    CouplingGains gains;
    Wrench push_B_W;  // wrench that the other peer reports for its end of the spring; for the lab
  };

  std::vector<InstanceInput> instances;
  /// Point tests that fit into a frame (paper §5, nCapacity): an input, so that runs can be
  /// repeated.
  double capacity = kDefaultCapacity;
  /// Point tests that take as long as an exact query at a point that may be in contact; an input as
  /// well.
  double query_price = kDefaultQueryPrice;
  Hand hand;
  HandClearance clearance;     // target, approached at kClearancePace within ClearanceBounds
  std::size_t link_count = 0;  // links, all on the body that the hand holds
  std::array<Link, kMaxLinkAnchors> links{};
  double ground_damping = 0;  // damping of the held body, N s/m
  Mat3 ground_rotation_damping = Mat3::Zero();
};

/// Frames of waiting for voxels, 2 s of them, after which a simulation ends (paper §5.3).
inline constexpr int kLongestVoxelWait = 2000;

/// Frames that could not be made because voxels were not in memory.
struct VoxelWaits {
  std::int64_t count = 0;   // number of waits
  std::int64_t frames = 0;  // frames of all waits
  int longest = 0;          // frames of the longest wait
};

/// The results of a frame.
struct StepReport {
  static constexpr std::uint32_t kTravelLimited = 1;  // a body was held back
  static constexpr std::uint32_t kOverCapacity = 2;   // MaxTravel is below half a voxel
  static constexpr std::uint32_t kContactsFull = 4;   // more contacts than a pair can hold
  /// Voxels are not in memory: nothing moves and nothing pulls at the hand until they are.
  static constexpr std::uint32_t kWaitsForVoxels = 8;

  std::uint32_t flags = 0;
  int waited = 0;  // consecutive frames, including this one, that waited for voxels
  int contact_points = 0;
  int exact_queries = 0;  // exact queries at single points (refined model)
  double query_cost = 0;  // cost of these queries and of adding up, in exact queries
  int pushing_points = 0;
  TestCounts tests;
  /// Wrench of the hand's coupling on the held body, as applied; NaN: its step was not finite.
  Wrench hand_B_W;
  /// The contact wrench on the held body, as the step applies it. With gravity, the hand, the
  /// links, the ground and the reaction of the body's joint it makes the change of momentum, until
  /// the travel limit holds the body back.
  Wrench contact_B_W;
  std::array<Wrench, kMaxLinkAnchors> links_B_W{};  // wrenches of couplings to copies, as applied
};

}  // namespace tandem
