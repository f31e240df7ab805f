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

/// Bodies that others move and we do not (paper §6.1, type-1), since they hold them or answer for
/// them as they fall: each has a mirror here that follows the newest received pose. How fast it may
/// follow is the world's to say: by at most its share of the travel limit, never in a jump. Used by
/// the haptic thread alone; nothing allocates after construction.
class RemoteBodies {
 public:
  static constexpr double kPart = 0.04;  // m
  static constexpr double kMeet = 0.02;
  static constexpr double kFarthestAhead_s = 0.1;  // of dead reckoning
  static constexpr double kFarthestAhead_m = 0.03;
  static constexpr double kHomeStep = 5e-5;  // m a frame
  static constexpr double kHomeTurn = 1e-3;  // rad a frame
  static constexpr double kEase_s = 0.05;    // of a free body's mirror: its lag fades so
  static constexpr int kGoesOn = 100;        // frames without news for which it goes on as told
  /// This loop is assumed where the authority of a loose body holds nothing, for none is measured.
  static constexpr double kUnknownLoop_s = 0.2;

  explicit RemoteBodies(const WorldModel& model, MirrorModel mirror = MirrorModel::kBlend);

  void OnMembership(const MembershipChange& change) noexcept;
  /// Takes states of held, of loose and of parked bodies; the last end what was told of loose ones.
  void OnState(const ObjectState& state) noexcept;
  /// Others from whom at least one state has come.
  std::size_t heard() const noexcept;

  /// Where dead reckoning takes the instances to be now, each by half the age of its peer's loop;
  /// before Prepare(). Other models stay with what was received.
  void Reckon(std::span<const Echoes::Loop> loops) noexcept;

  /// Says of every body but `held` (index into the moving bodies, or -1) who moves it.
  ///
  /// A shared body in several hands is met as one thing, the mean of its instances, until two of
  /// them are kPart from one another: from then as both, each the mean of those nearest to it,
  /// until they are within kMeet again.
  void Prepare(int held, StepInputs& inputs) noexcept;
  /// The body is simulated here in this frame. A free one that was not before goes on as its peer
  /// last said. After Prepare().
  void TakeOver(std::size_t body, StepInputs& inputs) noexcept;
  /// A free body that was simulated here until now is `peer`'s: its mirror goes on from there.
  /// After Prepare().
  void HandOn(std::size_t body, PeerId peer, const RigidState& state, StepInputs& inputs) noexcept;
  /// The mirror of a free body goes on as it was told to move, and its lag fades: so it neither
  /// stops nor jumps where another peer takes it over.
  ///
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
    std::uint32_t epoch = 0;  // of its claim, while it holds
    bool heard = false;
    ObjectState state;  // received
    Pose X_WB;          // where the instance is taken to be
  };
  struct Body {
    ObjectId object = 0;
    bool free = false;
    bool eased = false;  // free, and never in several hands
    bool parted = false;
    bool eases = false;  // goes home at kHomeStep
    double lag = 0;      // m
    ContactBlend blend{};
    ContactBlend second_blend{};
    std::array<Instance, kMaxPeers> instances{};
    Instance loose;       // while it is in nobody's hand: at the peer that answers for it
    Twist told_V_WB;      // of a free body, newest
    int told_frames = 0;  // since then
  };

  /// Where the body's instances are: in one place, or in two.
  static void Place(Body& body, StepInputs::BodyInput& input) noexcept;
  /// The worst loop to those who move it, s; less than 0: nobody does.
  static double WorstLoop(const Body& body, std::span<const Echoes::Loop> loops) noexcept;
  /// Of a body that nobody holds: less of its way, where it might jolt a hand.
  static void GoHome(Body& body, bool pushed, const RigidState& state,
                     StepInputs::BodyInput& input) noexcept;
  /// The next pose of a free body's mirror, in place of the one that it was told to be at.
  static void Ease(const Body& body, const RigidState& state,
                   StepInputs::BodyInput& input) noexcept;
  /// Of one instance: whether it yields, and how it is pulled then.
  static bool Yields(ContactBlend& blend, bool pushed, double te_s, const RigidState& state,
                     const Pose& target_WB, const Inertia& inertia, double& most_lag,
                     CouplingGains& pull) noexcept;
  static Instance* Find(Body& body, PeerId peer) noexcept;
  /// Where an instance would be by now, of a loop of that age.
  static Pose Ahead(const ObjectState& state, double loop_age_s) noexcept;

  MirrorModel mirror_;
  std::vector<Body> bodies_;
  double mirror_lag_ = 0;
};

}  // namespace tandem
