#pragma once

#include "engine/base/linearized_force.h"

namespace tandem {

/// The mass of a free rigid body.
struct Inertia {
  double mass = 1.0;            // kg
  Mat3 I_B = Mat3::Identity();  // about the centre of mass, axes of B, kg m^2
};

/// A pose and its rate of change; B's origin is the centre of mass.
struct RigidState {
  Pose X_WB;
  Twist V_WB;
};

/// The equations A V = b for the twist V at the end of a step, in W, angular part first.
struct StepEquations {
  Mat6 A;
  Vec6 b;
};

/// Returns the equations of one linearly implicit step of length h (s) of a free body:
///   (M + h G + h D + h^2 K) V = (M + h D) V0 + h F
/// with the load's force F, stiffness K and damping D at the beginning of the step. G is the
/// gyroscopic moment w x I w0 = G V, which does no work on the new w: a body that nothing pulls
/// never gains energy, however fast it tumbles. The step is correct in the limit of small steps,
/// and stable for any stiffness (docs/decisions/0004-contact-and-step.md).
StepEquations ImplicitEquations(const Inertia& inertia, const RigidState& state,
                                const LinearizedForce& load, double h) noexcept;
/// Returns the same without G, for AdvanceFreely().
StepEquations EquationsWithoutSpin(const Inertia& inertia, const RigidState& state,
                                   const LinearizedForce& load, double h) noexcept;

/// Returns their solution.
Twist ImplicitTwist(const Inertia& inertia, const RigidState& state, const LinearizedForce& load,
                    double h) noexcept;

/// Moves the state by `V_WB` for h seconds. It scales the whole twist down so that no surface point
/// goes farther than `max_travel` (m). The scaled twist is the new velocity, so that nothing winds
/// up. A twist that is not finite leaves the state in place, at rest. Returns the travel made, m.
double Advance(RigidState& state, const Twist& V_WB, double h, double radius,
               double max_travel) noexcept;

/// Moves `X_WB` towards `target`, no surface point farther than `max_travel` (m), for bodies whose
/// motion is decided elsewhere. Sets the twist of this step. Returns the travel made, m.
double Follow(RigidState& state, const Pose& target, double h, double radius,
              double max_travel) noexcept;

}  // namespace tandem
