#include "engine/world/applied_force_report.h"

#include <limits>

namespace tandem {

void AppliedForceReport::Clear() noexcept {
  contact_ = {};
  contact_of_others_.setZero();
}

void AppliedForceReport::Couple(const StepInputs& in, const RigidState& held,
                                LinearizedForce& load) noexcept {
  hand_ = CouplingForce(in.hand.gains, held, in.hand.X_BD, in.hand.goal);
  load += hand_;
  for (std::size_t k = 0; k < in.link_count; ++k) {
    links_[k] = CentreCouplingForce(in.links[k].gains, held, in.links[k].copy);
    links_[k].F_B_W += in.links[k].push_B_W;
    links_[k].AddTo(load);
  }
  load += GroundDamping(in.ground_damping, in.ground_rotation_damping, held);
}

void AppliedForceReport::AddContactOfOther(const CrossJacobian& cross, bool is_shell,
                                           const Vec6& before, const Vec6& after) noexcept {
  if (is_shell) {
    contact_of_others_ += cross.damping * (after - before) + kFrame * cross.stiffness * after;
  } else {
    contact_of_others_ +=
        cross.damping.transpose() * (after - before) + kFrame * cross.stiffness.transpose() * after;
  }
}

void AppliedForceReport::Report(const StepInputs& in, const Twist& before, const Twist& desired,
                                const Twist& after, StepReport& report) const noexcept {
  if (!desired.v.allFinite() || !desired.w.allFinite()) {
    // the body stands, and the hand's wrench is not known
    report.hand_B_W.f.setConstant(std::numeric_limits<double>::quiet_NaN());
    report.hand_B_W.tau = report.hand_B_W.f;
    return;
  }
  report.contact_B_W = AppliedContact(before, desired);
  report.hand_B_W = AppliedWrench(hand_, before, after, kFrame);
  for (std::size_t k = 0; k < in.link_count; ++k) {
    report.links_B_W[k] = AppliedWrench(links_[k], before, after, kFrame);
  }
}

Wrench AppliedForceReport::AppliedContact(const Twist& before, const Twist& after) const noexcept {
  Wrench applied = AppliedWrench(contact_, before, after, kFrame);
  applied.tau += contact_of_others_.head<3>();
  applied.f += contact_of_others_.tail<3>();
  return applied;
}

}  // namespace tandem
