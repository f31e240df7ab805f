#pragma once

#include <array>

#include "engine/base/linearized_force.h"
#include "engine/dynamics/virtual_coupling.h"
#include "engine/world/step_inputs.h"

namespace tandem {

/// The loads of a frame on the body that the hand holds, for the report of what the step applied.
class AppliedForceReport {
 public:
  /// Forgets the loads of the last frame.
  void Clear() noexcept;
  /// Notes the load of contact at the frame's start.
  void SetContact(const LinearizedForce& load) noexcept { contact_ = load; }
  /// Adds the loads of the hand, of the links and of damping against the ground.
  void Couple(const StepInputs& in, const RigidState& held, LinearizedForce& load) noexcept;
  /// Adds what the load of contact changes in the step as another body's twist changes. `is_shell`:
  /// the held body is the shell of the pair.
  void AddContactOfOther(const CrossJacobian& cross, bool is_shell, const Vec6& before,
                         const Vec6& after) noexcept;
  /// Reports the wrenches of the step that takes the held body from one twist to another.
  /// `desired`: the twist that it would have without limits.
  void Report(const StepInputs& in, const Twist& before, const Twist& desired, const Twist& after,
              StepReport& report) const noexcept;

 private:
  Wrench AppliedContact(const Twist& before, const Twist& after) const noexcept;

  LinearizedForce hand_;
  LinearizedForce contact_;
  Vec6 contact_of_others_ = Vec6::Zero();  // change of that load in the step as other bodies move
  std::array<CentreForce, kMaxLinkAnchors> links_;
};

}  // namespace tandem
