#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "collab/holdings.h"
#include "collab/retrace.h"
#include "collab/shared_body.h"
#include "collab/trap_detector.h"

namespace tandem {

/// What happens when something fixed has come between our instance of the body in hand and
/// another's (paper §6.1; docs/decisions/0023-apart.md): it is told and shown, the coupling pulls
/// with kMostForce at the most, and after kPatienceNs, or at once when a user asks, one of the two
/// comes back to the other (Retrace). That is everyone who is parted from the holder of the lowest
/// id, who stays: so all of any number meet on one side. Meanwhile the hand is let go of, softly,
/// and afterwards takes the body where it then is. Another holder could have it taken out of our
/// hand so all the time: unless our own user asks, it comes along twice and once more every
/// kComesAgainNs. Used by the haptic thread alone; nothing allocates after construction.
class Parting {
 public:
  static constexpr double kMostForce = 3.0;  // N
  static constexpr std::int64_t kPatienceNs = 2'000'000'000;
  static constexpr std::int64_t kComesAgainNs = 30'000'000'000;
  static constexpr double kLetGo = 0.2;  // s
  static constexpr double kTakeUp = 0.5;

  Parting(PeerId self, const WorldModel& model);

  /// A shared body is in hand now (into the moving bodies), or none is (-1).
  void Begin(int body) noexcept;
  /// Our user wants to be brought together again.
  void Ask() noexcept { asked_ = true; }
  /// Another holder wants it.
  void AskForAnother() noexcept { asked_by_another_ = true; }
  /// First in a frame: where the instances are; caps the links.
  void Look(std::int64_t now_ns, const RigidState& own, SharedBody& shared) noexcept;
  /// Then, with the hand as it would pull: lets it pull less, or draws the body along in its place.
  /// `X_BD`: the grasp, taken anew where the hand finds the body elsewhere.
  void Lead(const RigidState& own, const Pose& X_WD, Pose& X_BD, StepInputs::Hand& hand) noexcept;

  /// Whether a straight line to any other's is blocked now.
  bool apart() const noexcept { return apart_; }
  /// Whether something is between us and any other, to stay.
  bool trapped() const noexcept { return trapped_; }
  bool trapped(PeerId peer) const noexcept { return detector_.trapped(peer); }
  /// Whether the body comes along its way and the hand feels nothing.
  bool leading() const noexcept { return phase_ == Phase::kLeading; }
  bool TakeNews(HoldingNews& news) noexcept;

 private:
  enum class Phase : std::uint8_t { kInHand, kLettingGo, kLeading, kTakingUp };

  void Keep(const RigidState& own, const std::array<InstanceView, kMaxLinks>& others,
            std::size_t count) noexcept;
  /// Tells whether the body may come along once more without our user's word, and counts it.
  bool MayCome(std::int64_t now_ns) noexcept;
  /// Starts, or goes on with, the way to `lowest`.
  void Heal(std::int64_t now_ns, PeerId lowest) noexcept;
  /// A frame of the search for the way to `lowest`; lets go of the body when it is found.
  void Seek(PeerId lowest) noexcept;
  void Tell(HoldingNews::Kind kind, PeerId peer) noexcept;
  const BodyModel& body() const noexcept { return model_->bodies[static_cast<std::size_t>(body_)]; }

  PeerId self_;
  const WorldModel* model_;
  TrapDetector detector_;
  PoseHistory history_;
  Retrace retrace_;
  int body_ = -1;
  std::int64_t frames_ = 0;
  bool trapped_ = false;
  bool apart_ = false;
  bool asked_ = false;
  bool asked_by_another_ = false;
  std::array<PeerId, kMaxLinks> told_{};  // of whom it was told that we are apart; 0: a free place
  PeerId given_up_ = 0;                   // the way to that one failed: only asked for again
  std::int64_t paid_ns_ =
      0;  // when the body has paid off how often it came without our user's word
  std::int64_t apart_since_ns_ = 0;  // trapped against the lowest; 0: not
  Phase phase_ = Phase::kInHand;
  double hand_share_ = 1;  // of its pull
  std::array<HoldingNews, 8> news_{};
  std::size_t news_count_ = 0;
};

}  // namespace tandem
