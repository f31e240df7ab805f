#include "engine/world/held_loads.h"

#include <limits>

namespace tandem {

void HeldLoads::Clear() noexcept {
  contact_ = {};
  contact_of_others_.setZero();
}

void HeldLoads::Couple(const StepInputs& in, const RigidState& held, Load& load) noexcept {
  hand_ = CouplingLoad(in.hand.gains, held, in.hand.X_BD, in.hand.goal);
  load += hand_;
  for (std::size_t k = 0; k < in.link_count; ++k) {
    links_[k] = CentreCouplingLoad(in.links[k].gains, held, in.links[k].copy);
    links_[k].F_B_W += in.links[k].push_B_W;
    links_[k].AddTo(load);
  }
  load += GroundDamping(in.ground_damping, in.ground_rotation_damping, held);
}

void HeldLoads::AddContactOfOther(const CrossLoad& cross, bool is_shell, const Vec6& before,
                                  const Vec6& after) noexcept {
  if (is_shell) {
    contact_of_others_ += cross.damping * (after - before) + kFrame * cross.stiffness * after;
  } else {
    contact_of_others_ +=
        cross.damping.transpose() * (after - before) + kFrame * cross.stiffness.transpose() * after;
  }
}

void HeldLoads::Report(const StepInputs& in, const Twist& before, const Twist& wanted,
                       const Twist& after, StepReport& report) const noexcept {
  if (!wanted.v.allFinite() || !wanted.w.allFinite()) {
    // the body stands, and the hand's wrench is not known
    report.hand_B_W.f.setConstant(std::numeric_limits<double>::quiet_NaN());
    report.hand_B_W.tau = report.hand_B_W.f;
    return;
  }
  report.contact_B_W = AppliedContact(before, wanted);
  report.hand_B_W = AppliedWrench(hand_, before, after, kFrame);
  for (std::size_t k = 0; k < in.link_count; ++k) {
    report.links_B_W[k] = AppliedWrench(links_[k], before, after, kFrame);
  }
}

Wrench HeldLoads::AppliedContact(const Twist& before, const Twist& after) const noexcept {
  Wrench applied = AppliedWrench(contact_, before, after, kFrame);
  applied.tau += contact_of_others_.head<3>();
  applied.f += contact_of_others_.tail<3>();
  return applied;
}

}  // namespace tandem
