#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collab/coupling/round_trip_tracker.h"
#include "collab/mirror/mirror_compliance.h"
#include "collab/session/membership.h"
#include "collab/session/peer_map.h"
#include "engine/base/experiment_options.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Keeps the bodies that other peers move (paper §6.1, type-1), either in their hands or as they
/// fall. Each has a mirror here that follows the newest received pose: the first instance of the
/// body in the world. A shared body has a second mirror, its second instance, which is active while
/// its holders have it in two places. The world limits a mirror's speed to its share of the travel
/// limit, without jumps. Used by the haptic thread alone; nothing allocates after construction.
class RemoteBodies {
 public:
  static constexpr double kPart = 0.04;  // m; instances farther apart are met as two
  static constexpr double kMeet = 0.02;  // m; instances nearer than this are met as one again
  static constexpr double kFarthestAhead_s = 0.1;  // limit of dead reckoning
  static constexpr double kFarthestAhead_m = 0.03;
  static constexpr double kHomeStep = 5e-5;  // m a frame
  static constexpr double kHomeTurn = 1e-3;  // rad a frame
  static constexpr double kEase_s = 0.05;    // time constant of a free body's mirror lag
  static constexpr int kGoesOn = 100;  // frames without news in which a mirror keeps its velocity
  /// Loop age assumed where the authority of a loose body holds nothing, so that no loop is
  /// measured.
  static constexpr double kUnknownLoop_s = 0.2;

  explicit RemoteBodies(const WorldModel& model,
                        MirrorModel mirror = MirrorModel::kCompliantMirror);

  void OnMembership(const MembershipChange& change) noexcept;
  /// Takes states of held, loose and parked bodies; a parked state ends the loose ones.
  void OnState(const ObjectState& state) noexcept;
  /// Counts the instances of other peers from which at least one state has come.
  std::size_t received_instances() const noexcept;

  /// Extrapolates each instance by half the age of its peer's loop, for dead reckoning; called
  /// before Prepare(). Other models stay with the received pose.
  void Extrapolate(std::span<const RoundTripTracker::Loop> loops) noexcept;

  /// Decides how every body but `held` (index into the moving bodies, or -1) is driven.
  ///
  /// A shared body in several hands is met as one body, the mean of its holders' instances, until
  /// two of these are kPart apart. Then it is met as two, each the mean of the nearest ones, until
  /// they are within kMeet again. The second instance in the world is inactive otherwise.
  void Prepare(int held, StepInputs& inputs) noexcept;
  /// Simulates the body here in this frame. A free body that was not simulated here goes on as its
  /// peer last said. After Prepare().
  void TakeOver(std::size_t body, StepInputs& inputs) noexcept;
  /// Gives `peer` a free body that was simulated here: its mirror goes on from there. After
  /// Prepare().
  void HandOver(std::size_t body, PeerId peer, const RigidState& state,
                StepInputs& inputs) noexcept;
  /// Lets pushed mirrors give way (MirrorCompliance), where the model says so, as far as the worst
  /// loop to the body's holders requires; after Prepare().
  ///
  /// A body that no peer holds yields to no push: it stays where it was put. If it was pushed or
  /// gave way, it returns there at kHomeStep and kHomeTurn. The mirror of a free body goes on with
  /// its received velocity while its lag fades. So it neither stops nor jumps when another peer
  /// takes it over.
  void ApplyCompliance(const World& world, std::span<const RoundTripTracker::Loop> loops,
                       StepInputs& inputs) noexcept;
  /// The greatest distance of a mirror from its received pose, m.
  double mirror_lag_m() const noexcept { return mirror_lag_; }
  /// The greatest such distance of the bodies that this peer moves, m.
  double LagOf(PeerId peer) const noexcept;

 private:
  struct Instance {
    PeerId peer = 0;
    bool holds = false;
    std::uint32_t epoch = 0;  // epoch of its claim, while it holds
    bool received = false;
    ObjectState state;  // received
    Pose X_WB;          // estimated pose of the instance
  };
  struct Body {
    ObjectId object = 0;
    bool free = false;
    bool eased = false;                     // free and not shared, so never in several hands
    bool parted = false;                    // its holders have it in two places
    bool eases = false;                     // returns home at kHomeStep
    double lag = 0;                         // m
    std::optional<InstanceIndex> second{};  // its second instance in the world, if it has one
    std::array<MirrorCompliance, 2> compliances{};  // one for each instance in the world
    PeerMap<Instance, kMaxPeers> instances{};
    Instance loose;       // the instance at its authority, while it is in no hand
    Twist told_V_WB;      // newest twist received for a free body
    int told_frames = 0;  // frames since told_V_WB
  };

  /// Finds where the holders have a body, in one place or in two, and places its mirrors there.
  void Place(std::size_t index, StepInputs& inputs) noexcept;
  /// Makes the second instance of a body inactive, if it has one.
  void MeetAsOne(std::size_t body, StepInputs& inputs) const noexcept;
  /// Returns the worst loop age to the peers that move the body, s; less than 0: no peer does.
  static double WorstLoop(const Body& body, std::span<const RoundTripTracker::Loop> loops) noexcept;
  /// Shortens the way of a body that no peer holds, where a jump might jolt a hand.
  static void ReturnToRest(Body& body, bool pushed, const RigidState& state,
                           StepInputs::InstanceInput& input) noexcept;
  /// Replaces the received pose of a free body's mirror by the next pose on its smooth way.
  static void SmoothTarget(const Body& body, const RigidState& state,
                           StepInputs::InstanceInput& input) noexcept;
  /// Lets a mirrored instance give way where it is pushed. `te_s`: the delay that gains are made
  /// for; `most_lag` becomes its lag if that is greater, m.
  void Yield(const World& world, InstanceIndex instance, double te_s, MirrorCompliance& compliance,
             double& most_lag, StepInputs::InstanceInput& input) const noexcept;
  /// Returns the extrapolated pose of an instance, for a loop of that age.
  static Pose ExtrapolatedPose(const ObjectState& state, double loop_age_s) noexcept;

  MirrorModel mirror_;
  std::vector<Body> bodies_;
  double mirror_lag_ = 0;
};

}  // namespace tandem
