#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "collab/contact_blend.h"
#include "collab/echoes.h"
#include "collab/membership.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What a mirror is while we push it.
enum class MirrorModel : std::uint8_t {
  kBlend,         // firm at first, then it gives way as the delay wants: ContactBlend
  kHeld,          // like a rock where its peer said last; for the lab
  kDeadReckoned,  // like a rock where it would be by now, as it moved then; for the lab
};

/// Bodies that others hold and we do not (paper §6.1, type-1): each has a mirror here that follows
/// the newest received pose. How fast it may follow is the world's to say: by at most its share of
/// the travel limit, never in a jump. Used by the haptic thread alone; nothing allocates after
/// construction.
class RemoteBodies {
 public:
  static constexpr double kPart = 0.04;  // m
  static constexpr double kMeet = 0.02;
  static constexpr double kFarthestAhead_s = 0.1;  // of dead reckoning
  static constexpr double kFarthestAhead_m = 0.03;
  static constexpr double kHomeStep = 5e-5;  // m a frame
  static constexpr double kHomeTurn = 1e-3;  // rad a frame

  explicit RemoteBodies(const WorldModel& model, MirrorModel mirror = MirrorModel::kBlend);

  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  /// Others from whom at least one state has come.
  std::size_t heard() const noexcept;

  /// Where dead reckoning takes the instances to be now, each by half the age of its peer's loop;
  /// before Prepare(). Other models stay with what was received.
  void Reckon(std::span<const Echoes::Loop> loops) noexcept;

  /// Says of every body but `held` (index into the moving bodies, or -1) who moves it. A free body
  /// that nobody holds is simulated here while no other active peer is in the session; with others
  /// it stands, since nobody's motion of it would be everybody's.
  ///
  /// A shared body in several hands is met as one thing, the mean of its instances, until two of
  /// them are kPart from one another: from then as both, each the mean of those nearest to it,
  /// until they are within kMeet again.
  void Prepare(int held, StepInputs& inputs) noexcept;
  /// Lets mirrors that are pushed give way (ContactBlend) as the worst loop wants that we have to
  /// those who hold the body, where they are of that model; after Prepare(). What nobody holds
  /// answers to no push: it stands where it was put, and one that is pushed or gave way comes there
  /// at kHomeStep and kHomeTurn.
  void GiveWay(const World& world, std::span<const Echoes::Loop> loops,
               StepInputs& inputs) noexcept;
  /// How far the mirrors were from the poses received, the farthest, m.
  double mirror_lag_m() const noexcept { return mirror_lag_; }
  /// Of those that this peer moves.
  double LagOf(PeerId peer) const noexcept;

 private:
  struct Instance {
    PeerId peer = 0;  // 0: a free place
    bool holds = false;
    bool heard = false;
    ObjectState state;  // received
    Pose X_WB;          // where the instance is taken to be
  };
  struct Body {
    ObjectId object = 0;
    bool free = false;
    bool parted = false;
    bool eases = false;  // goes home at kHomeStep
    double lag = 0;      // m
    ContactBlend blend{};
    ContactBlend second_blend{};
    std::array<Instance, kMaxPeers> instances{};
  };

  /// Where the body's instances are: in one place, or in two.
  static void Place(Body& body, StepInputs::BodyInput& input) noexcept;
  /// The worst loop to those who hold it, s; less than 0: nobody does.
  static double WorstLoop(const Body& body, std::span<const Echoes::Loop> loops) noexcept;
  /// Of a body that nobody holds: less of its way, where it might jolt a hand.
  static void GoHome(Body& body, bool pushed, const RigidState& state,
                     StepInputs::BodyInput& input) noexcept;
  /// Of one instance: whether it yields, and how it is pulled then.
  static bool Yields(ContactBlend& blend, bool pushed, double te_s, const RigidState& state,
                     const Pose& target_WB, const Inertia& inertia, double& most_lag,
                     CouplingGains& pull) noexcept;
  static Instance* Find(Body& body, PeerId peer) noexcept;

  MirrorModel mirror_;
  std::vector<Body> bodies_;
  double mirror_lag_ = 0;
  std::array<PeerId, kMaxPeers> present_{};  // other active peers; 0: a free place
};

}  // namespace tandem
