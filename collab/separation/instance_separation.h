#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "collab/coupling/shared_body.h"
#include "collab/ownership/ownership.h"
#include "collab/separation/return_path.h"
#include "collab/separation/trap_detector.h"
#include "collab/session/peer_map.h"

namespace tandem {

/// Handles a separation: something fixed has come between our instance of the body in hand and
/// another's (paper §6.1; docs/decisions/0023-apart.md). The user is told, the picture shows it,
/// and the coupling pulls with at most kMostForce. After kPatienceNs, or at once when a user asks,
/// one of the two instances comes back to the other (ReturnPath). The holder with the lowest id
/// stays, and each holder parted from it comes back, so that all meet on one side. Meanwhile the
/// hand lets go of the body, softly, and afterwards takes it where it then is. Another holder could
/// ask for this all the time, so without a request of our own user the body comes along twice, and
/// once more every kComesAgainNs. Used by the haptic thread alone; nothing allocates after
/// construction.
class InstanceSeparation {
 public:
  static constexpr double kMostForce = 3.0;  // N
  static constexpr std::int64_t kPatienceNs = 2'000'000'000;
  static constexpr std::int64_t kComesAgainNs = 30'000'000'000;
  static constexpr double kLetGo = 0.2;  // s
  static constexpr double kTakeUp = 0.5;

  InstanceSeparation(PeerId self, const WorldModel& model);

  /// Begins with a shared body that is in hand (index into the moving bodies), or with none (-1).
  void Begin(int body) noexcept;
  /// Notes that our user wants to be brought together again.
  void RequestReunion() noexcept { requested_by_user_ = true; }
  /// Notes that another holder wants it.
  void RequestReunionForPeer() noexcept { requested_by_peer_ = true; }
  /// Sees where the instances are and caps the links; first in a frame.
  void Update(std::int64_t now_ns, const RigidState& own, SharedBody& shared) noexcept;
  /// Then makes the hand pull less, or draws the body along in its place. `X_BD`: the grasp, taken
  /// anew where the hand finds the body elsewhere.
  void GuideHand(const RigidState& own, const Pose& X_WD, Pose& X_BD,
                 StepInputs::Hand& hand) noexcept;

  /// Returns whether a straight line to any other instance is blocked.
  bool apart() const noexcept { return apart_; }
  /// Returns whether something fixed separates us from any other instance for good.
  bool trapped() const noexcept { return trapped_; }
  bool trapped(PeerId peer) const noexcept { return detector_.trapped(peer); }
  /// Returns whether the body moves along its way back and the hand feels nothing.
  bool guiding() const noexcept { return phase_ == Phase::kGuiding; }
  bool TakeNotifications(Notification& notification) noexcept;

 private:
  enum class Phase : std::uint8_t { kInHand, kReleasing, kGuiding, kRegrasping };

  void Keep(const RigidState& own, const std::array<InstanceView, kMaxLinks>& others,
            std::size_t count) noexcept;
  /// Returns whether the body may come along once more without our user's request, and counts it.
  bool MayReturn(std::int64_t now_ns) noexcept;
  /// Starts the way to `lowest`, or goes on with it.
  void Reunite(std::int64_t now_ns, PeerId lowest) noexcept;
  /// Searches for the way to `lowest` for one frame; lets go of the body when it is found.
  void SearchPath(PeerId lowest) noexcept;
  void Tell(Notification::Kind kind, PeerId peer) noexcept;
  const BodyModel& body() const noexcept { return model_->bodies[static_cast<std::size_t>(body_)]; }

  PeerId self_;
  const WorldModel* model_;
  TrapDetector detector_;
  PoseHistory history_;
  ReturnPath return_path_;
  int body_ = -1;
  std::int64_t frames_ = 0;
  bool trapped_ = false;
  bool apart_ = false;
  bool requested_by_user_ = false;
  bool requested_by_peer_ = false;
  PeerSet<kMaxLinks> reported_;  // peers told to the user as apart
  PeerId given_up_ = 0;  // peer to which the way failed; the way is tried again only on request
  // when the body has paid off its moves without our user's request
  std::int64_t paid_ns_ = 0;
  std::int64_t apart_since_ns_ = 0;  // since when we are trapped against the lowest; 0: we are not
  Phase phase_ = Phase::kInHand;
  double hand_share_ = 1;  // share of the hand's pull in use
  std::array<Notification, 8> notifications_{};
  std::size_t news_count_ = 0;
};

}  // namespace tandem
