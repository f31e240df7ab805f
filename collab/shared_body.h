#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "collab/coupling_law.h"
#include "collab/messages.h"
#include "collab/partner.h"
#include "collab/sent_stamps.h"
#include "engine/world/step_inputs.h"

namespace tandem {

/// The couplings between the own instance of a shared body and the instances of the other users who
/// hold it (paper §6.1, type-2): multi-user virtual coupling, computed here from the others'
/// states.
///
///   me  --state, links-->  other          its links carry the newest stamp of mine that it holds:
///   me  <--state, links--  other          now - that stamp is the age of the whole loop
///
/// Both ends use the smaller of their two stiffnesses, made for the worst loop among the links, and
/// let the copy move as far as the energy gate pays. A link whose own loop is older than
/// kLongestCommonLoop is softer by itself; it ends when the session says that its user is gone. How
/// stiffness may change: StiffnessSlew. Used by the haptic thread alone; nothing allocates.
class SharedBody {
 public:
  struct Options {
    std::shared_ptr<const CouplingLaw> law = DefaultLaw();
    bool gate = true;  // off: for comparison only
    /// Forces in place of states, to show what they do, in the lab alone: each end works out the
    /// spring between its instance and the copy, tells the other that force, and applies the one
    /// that it is told of. Unstable from a quarter of k_crit on.
    bool exchange_forces = false;
  };

  SharedBody(PeerId self, ObjectId object, const Inertia& inertia, const Options& options);

  /// Another user holds the body now, or again. False: kMaxLinks others do already, and this one
  /// stays uncoupled.
  bool Join(PeerId peer) noexcept;
  /// Its pull fades over 200 ms, or longer: all links whose stiffness falls have equal parts of
  /// 8 N/s. Then it is forgotten.
  void Part(PeerId peer) noexcept;

  void OnState(const ObjectState& state) noexcept;
  void OnLinks(const CouplingLinks& links) noexcept;

  /// Brings the stiffnesses up to date and writes the couplings of the coming frame.
  void Prepare(std::int64_t now_ns, const RigidState& own, StepInputs& inputs) noexcept;
  /// What to tell the others with the state of this frame; `report`: of the same frame.
  void Describe(std::int64_t now_ns, std::uint32_t seq, const StepReport& report,
                CouplingLinks& out) noexcept;

  /// Others whose loop is closed: they are heard, and they have heard us.
  std::size_t coupled() const noexcept;
  /// Half the largest present loop age over the partners, s; 0 without any.
  double delay_s(std::int64_t now_ns) const noexcept;
  /// Half the loop age, mean over all partners and frames so far, those that are gone included, s.
  double mean_delay_s() const noexcept {
    return delays_ == 0 ? 0.0 : delay_sum_s_ / static_cast<double>(delays_);
  }
  /// The links of the last frame, at most kMaxLinks; gives how many. The two wrenches of a link are
  /// opposite at rest; in motion each end sees the other's past.
  std::size_t Links(std::int64_t now_ns, std::array<LinkView, kMaxLinks>& out) const noexcept;
  /// The instances of those who are here and heard, at most kMaxLinks; gives how many.
  std::size_t Instances(std::array<InstanceView, kMaxLinks>& out) const noexcept;
  /// From now on a partner's link pulls with at most `newtons`; where it pulls with more it falls
  /// gently, and its other end with it.
  void CapForce(PeerId peer, double newtons) noexcept;
  /// Until the next CapForce() it pulls with that share of what it did when it began to fade, and
  /// its other end with it: as fast as the share falls.
  void FadeForce(PeerId peer, double share) noexcept;
  /// Drag against the ground in the last frame, N s/m.
  double ground_damping() const noexcept { return ground_damping_; }
  /// Echoes refused: of a time at which we sent nothing, or older than the one before.
  std::uint64_t bad_echoes() const noexcept { return bad_echoes_; }

 private:
  Partner* Find(PeerId peer) noexcept;
  /// Takes the delays of the frame; gives the inputs of the law.
  LawInputs MeasureDelays(std::int64_t now_ns) noexcept;
  /// Pays the gates for what drag took out in the last frame, and brings the copies up to date.
  void Admit(const RigidState& own, const Mat3& per_mass) noexcept;
  /// Brings the stiffnesses up to date. `V_own_WB`: of the own instance.
  void Slew(std::int64_t now_ns, const LawInputs& common, const Twist& V_own_WB,
            const Mat3& per_mass) noexcept;
  /// The largest peak of any closed link, s.
  double WorstLoopAge() const noexcept;

  PeerId self_;
  ObjectId object_;
  Inertia inertia_;
  double gyration_;  // m
  Options options_;
  std::array<Partner, kMaxLinks> partners_{};
  std::array<std::size_t, kMaxLinks> partner_of_link_{};  // of the coming frame's links
  std::size_t link_count_ = 0;
  double longest_loop_age_s_ = 0;  // of all links in the last minutes, slowly forgotten
  double ground_damping_ = 0;      // N s/m, of the last frame
  SentStamps sent_;
  std::uint64_t bad_echoes_ = 0;
  std::int64_t last_frame_ns_ = 0;
  double delay_sum_s_ = 0;
  std::uint64_t delays_ = 0;
};

}  // namespace tandem
