#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contact/schedule.h"
#include "engine/dynamics/virtual_coupling.h"

namespace tandem {

inline constexpr std::size_t kMaxLinkAnchors = 8;
inline constexpr double kDefaultCapacity = 1e5;  // of a frame of 1 ms, on slow processors too
inline constexpr double kDefaultLookPrice = 400;

/// What moves a body in a frame.
enum class BodyDrive : std::uint8_t {
  kAbsent,     // a second instance that there is none of now
  kParked,     // nobody: it stands
  kSimulated,  // forces, here
  kMirrored,   // another peer, whose pose it follows
  kYielding    // another peer, to whose pose it is pulled: it gives way where it is pushed
};

/// Everything from outside that a frame depends on. Sized once, for all moving bodies.
struct StepInputs {
  struct BodyInput {
    BodyDrive drive = BodyDrive::kParked;
    Pose mirror_WB;       // where a mirrored or yielding body is to go
    Twist begin_V_WB;     // of one that is mirrored no more, as it begins to be simulated
    CouplingGains pull;   // of a yielding body: springs to that pose, dampers against the ground
    bool parted = false;  // others' instances of a shared body are in two places:
    BodyDrive second_drive = BodyDrive::kMirrored;  // of the other one of them, or yielding
    Pose second_WB;
    CouplingGains second_pull;
  };
  struct Hand {
    int body = -1;  // into WorldModel::bodies; -1: the hand holds nothing
    Pose X_BD;      // grasp
    Anchor goal;    // the device
    CouplingGains gains;
  };
  /// How far from other bodies' surfaces the body in hand meets them (paper §3.2); all others keep
  /// to the scene.
  struct HandClearance {
    static constexpr int kSceneLayer = -1;
    int force_layer = kSceneLayer;
    double displacement = 0;  // m, along the inward normals, of the pointshells of its pairs
  };
  struct Link {
    Anchor copy;  // another user's instance of the held body
    CouplingGains gains;
    Wrench push_B_W;  // what the other says that its end of the spring pulls with; for the lab
  };

  std::vector<BodyInput> bodies;
  /// Point tests that fit into a frame (paper §5, nCapacity): an input, so that runs can be
  /// repeated.
  double capacity = kDefaultCapacity;
  /// Point tests that take as long as an exact look at a point that may be in contact; an input as
  /// well.
  double look_price = kDefaultLookPrice;
  Hand hand;
  HandClearance clearance;     // gone to at kClearancePace, within ClearanceBounds
  std::size_t link_count = 0;  // all on the body that the hand holds
  std::array<Link, kMaxLinkAnchors> links{};
  double ground_damping = 0;  // of the held body, N s/m
  Mat3 ground_rotation_damping = Mat3::Zero();
};

/// Frames of waiting for voxels, 2 s of them, after which a simulation ends (paper §5.3).
inline constexpr int kLongestVoxelWait = 2000;

/// Frames that could not be made because voxels were not in memory.
struct VoxelWaits {
  std::int64_t count = 0;   // of times that something was waited for
  std::int64_t frames = 0;  // in all
  int longest = 0;          // frames
};

/// What a frame did.
struct StepReport {
  static constexpr std::uint32_t kTravelLimited = 1;  // some body was held back
  static constexpr std::uint32_t kOverCapacity = 2;   // MaxTravel is below half a voxel
  static constexpr std::uint32_t kContactsFull = 4;   // more contacts than a pair can hold
  /// Voxels are not in memory: nothing moves and nothing pulls at the hand until they are.
  static constexpr std::uint32_t kWaitsForVoxels = 8;

  std::uint32_t flags = 0;
  int waited = 0;  // frames on end, this one included, that waited for voxels
  int contact_points = 0;
  int looks = 0;         // exact looks at single points (refined model)
  double look_work = 0;  // what these and adding up came to, in exact looks
  int loaded_points = 0;
  TestCounts tests;
  Wrench hand_B_W;  // hand's coupling on the held body, as applied; NaN: its step was no number
  /// Contact on the held body, as the step applies it: with gravity, the hand, the links, the
  /// ground and the reaction of the body's joint it makes the change of momentum, until the travel
  /// limit holds the body back.
  Wrench contact_B_W;
  std::array<Wrench, kMaxLinkAnchors> links_B_W{};  // couplings to copies, as applied
};

}  // namespace tandem
