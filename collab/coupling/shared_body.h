#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "collab/coupling/coupling_law.h"
#include "collab/coupling/coupling_link.h"
#include "collab/coupling/link_views.h"
#include "collab/receive/sent_stamps.h"
#include "collab/session/messages.h"
#include "collab/session/peer_map.h"
#include "engine/world/step_inputs.h"

namespace tandem {

/// Couples the own instance of a shared body to the instances of the other users who hold it (paper
/// §6.1, type-2). This multi-user virtual coupling is computed here from the other users' states.
///
///   me  --state, links-->  other          its links carry the newest stamp of mine that it has:
///   me  <--state, links--  other          now - that stamp is the age of the whole loop
///
/// Both ends use the smaller of their two stiffnesses. These are made for the worst loop of the
/// links, and the copy moves as far as the energy gate pays. A link whose own loop is older than
/// kLongestCommonLoop is softer by itself; it ends when its user has left the session.
/// StiffnessLimiter limits changes of stiffness. Each link is a CouplingLink; this class keeps what
/// the links share. Used by the haptic thread alone; nothing allocates.
class SharedBody {
 public:
  struct Options {
    std::shared_ptr<const CouplingLaw> law = DefaultLaw();
    ExperimentOptions experiments{};
  };

  SharedBody(PeerId self, ObjectId object, const Inertia& inertia, const Options& options);

  /// Couples another user that holds the body, or holds it again. Returns false if kMaxLinks others
  /// do already; then this one stays uncoupled.
  bool Join(PeerId peer) noexcept;
  /// Fades the link to a user over 200 ms, or longer: all links whose stiffness falls share 8 N/s
  /// equally. Then the user is forgotten.
  void Part(PeerId peer) noexcept;

  void OnState(const ObjectState& state) noexcept;
  void OnLinks(const CouplingLinks& links) noexcept;

  /// Updates the stiffnesses and writes the couplings of the coming frame.
  void Prepare(std::int64_t now_ns, const RigidState& own, StepInputs& inputs) noexcept;
  /// Writes the links to send with the state of this frame; `report`: of the same frame.
  void Describe(std::int64_t now_ns, std::uint32_t seq, const StepReport& report,
                CouplingLinks& out) noexcept;

  /// Counts the users whose loop is closed: they are heard, and have heard us.
  std::size_t coupled() const noexcept;
  /// Half the largest present loop age over the coupled peers, s; 0 without any.
  double delay_s(std::int64_t now_ns) const noexcept;
  /// Half the loop age, mean over all frames and coupled peers so far, including those that are
  /// gone, s.
  double mean_delay_s() const noexcept {
    return delays_ == 0 ? 0.0 : delay_sum_s_ / static_cast<double>(delays_);
  }
  /// Writes the links of the last frame, at most kMaxLinks; returns how many. The two wrenches of a
  /// link are opposite at rest; in motion each end sees the other's past.
  std::size_t Links(std::int64_t now_ns, std::array<LinkView, kMaxLinks>& out) const noexcept;
  /// Writes the instances of users that are here and heard, at most kMaxLinks; returns how many.
  std::size_t Instances(std::array<InstanceView, kMaxLinks>& out) const noexcept;
  /// Limits the force of the link to a peer to `newtons` from now on. A greater force falls gently,
  /// and the link's other end follows.
  void CapForce(PeerId peer, double newtons) noexcept;
  /// Scales the link to a peer to `share` of its force when the fade began, until the next
  /// CapForce(). It follows the share at once, and its other end too.
  void FadeForce(PeerId peer, double share) noexcept;
  /// Drag against the ground in the last frame, N s/m.
  double ground_damping() const noexcept { return ground_damping_; }
  /// Echoes refused: a stamp that we never sent, or one older than the last.
  std::uint64_t bad_echoes() const noexcept { return bad_echoes_; }

 private:
  struct Coupled {
    PeerId peer = 0;
    CouplingLink link;
  };

  /// Measures the delays of the frame; returns the inputs of the law.
  LawInputs MeasureDelays(std::int64_t now_ns) noexcept;
  /// Adds the energy dissipated by drag in the last frame to the gates, and moves the copies.
  void MoveCopies(const LinkFrame& frame) noexcept;
  /// Updates the stiffnesses of all links.
  void Slew(const LinkFrame& frame, const LawInputs& common) noexcept;
  /// Forgets the links that have faded, and writes the others. Returns the sum of their
  /// stiffnesses, N/m.
  double Couple(const LinkFrame& frame, StepInputs& inputs) noexcept;
  void SetDrag(LawInputs common, double stiffness_sum, const Mat3& per_mass,
               StepInputs& inputs) noexcept;
  /// Returns the largest peak age of any closed link's loop, s.
  double WorstLoopAge() const noexcept;

  PeerId self_;
  ObjectId object_;
  Inertia inertia_;
  double gyration_;  // m
  Options options_;
  PeerMap<Coupled, kMaxLinks> links_;
  std::array<std::size_t, kMaxLinks> slots_{};  // in links_, of the links of the coming frame
  std::size_t link_count_ = 0;
  double longest_loop_age_s_ = 0;  // greatest age of any link in the last minutes, decaying slowly
  double ground_damping_ = 0;      // N s/m; in the last frame
  SentStamps sent_;
  std::uint64_t bad_echoes_ = 0;
  std::int64_t last_frame_ns_ = 0;
  double delay_sum_s_ = 0;
  std::uint64_t delays_ = 0;
};

}  // namespace tandem
