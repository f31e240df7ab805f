#pragma once

#include <array>
#include <cstdint>

#include "collab/delay_meter.h"
#include "collab/messages.h"
#include "collab/stiffness_schedule.h"
#include "engine/world/step_inputs.h"

namespace tandem {

/// The couplings between the own instance of a shared body and the instances of the other users who
/// hold it (paper §6.1, type-2): multi-user virtual coupling, computed here from the others'
/// states.
///
///   me  --state/1, link/1-->  other          link/1 carries the newest stamp of mine that the
///   other holds: me  <--state/1, link/1--  other          now - that stamp is the age of the whole
///   loop
///
/// Both ends use the smaller of their two stiffnesses. A rise is slowed so that a stretched spring
/// takes in at most 20 mW, a fall takes 20 ms. Used by the haptic thread alone; nothing allocates.
class SharedBody {
 public:
  struct Options {
    CouplingLaw law = CouplingLaw::kPlusDamping;
    CouplingLimits limits;
  };

  SharedBody(PeerId self, ObjectId object, const Inertia& inertia, const Options& options);

  /// Another user holds the body now, or again.
  void Join(PeerId peer) noexcept;
  /// Its pull fades over 200 ms; then it is forgotten.
  void Part(PeerId peer) noexcept;

  void OnState(const ObjectState& state) noexcept;
  void OnLinks(const CouplingLinks& links) noexcept;

  /// Brings the stiffnesses up to date and writes the couplings of the coming frame.
  void Prepare(std::int64_t now_ns, const RigidState& own, StepInputs& inputs) noexcept;
  /// What to tell the others with the state of this frame; `report`: of the same frame.
  void Describe(std::int64_t now_ns, std::uint32_t seq, const StepReport& report,
                CouplingLinks& out) const noexcept;

  /// Others whose loop is closed: they are heard, and they have heard us.
  std::size_t coupled() const noexcept;
  /// Half the largest present loop age over the partners, s; 0 without any.
  double delay_s(std::int64_t now_ns) const noexcept;
  /// Half the loop age, mean over all partners and frames so far, those that are gone included, s.
  double mean_delay_s() const noexcept {
    return delays_ == 0 ? 0.0 : delay_sum_s_ / static_cast<double>(delays_);
  }

 private:
  struct Partner {
    PeerId peer = 0;  // 0: a free place
    bool present = false;
    double fade = 1.0;  // of the pull, down to 0 after Part()
    bool heard = false;
    ObjectState state;  // newest
    bool linked = false;
    std::uint32_t links_seq = 0;
    std::int64_t echo_ns = 0;  // newest own stamp that it holds
    double its_stiffness = 0;  // N/m that it would use
    double stiffness = 0;      // N/m in use
    DelayMeter meter;
  };

  Partner* Find(PeerId peer) noexcept;

  PeerId self_;
  ObjectId object_;
  Inertia inertia_;
  Options options_;
  std::array<Partner, kMaxLinks> partners_{};
  double own_stiffness_ = 0;                              // what the law gives us now
  std::array<std::size_t, kMaxLinks> partner_of_link_{};  // of the coming frame's links
  std::size_t link_count_ = 0;
  double delay_sum_s_ = 0;
  std::uint64_t delays_ = 0;
};

}  // namespace tandem
