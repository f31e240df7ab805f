#pragma once

#include "engine/base/load.h"

namespace tandem {

/// A body's mass, as a free rigid body has it.
struct Inertia {
  double mass = 1.0;            // kg
  Mat3 I_B = Mat3::Identity();  // about the centre of mass, axes of B, kg m^2
};

/// A pose and how fast it changes: B's origin is the centre of mass.
struct RigidState {
  Pose X_WB;
  Twist V_WB;
};

/// A V = b for the twist V at the end of a step, in W, turning first.
struct StepEquations {
  Mat6 A;
  Vec6 b;
};

/// One linearly implicit step of length h (s) of a free body:
///   (M + h G + h D + h^2 K) V = (M + h D) V0 + h F
/// with the load's force F, stiffness K and damping D at the beginning of the step, and the
/// gyroscopic moment w x I w0 = G V, which does no work on the new w: so a body that nothing pulls
/// never gains energy, however fast it tumbles. Correct in the limit of small steps; stable for any
/// stiffness (docs/decisions/0004-contact-and-step.md).
StepEquations ImplicitEquations(const Inertia& inertia, const RigidState& state, const Load& load,
                                double h) noexcept;

/// Their solution.
Twist ImplicitTwist(const Inertia& inertia, const RigidState& state, const Load& load,
                    double h) noexcept;

/// Moves the state by `V_WB` for h seconds, the whole twist scaled down so that no surface point
/// goes farther than `max_travel` (m); the scaled twist is the new velocity, so that nothing winds
/// up. A twist that is no number leaves it where it is, at rest. Returns the travel made, m.
double Advance(RigidState& state, const Twist& V_WB, double h, double radius,
               double max_travel) noexcept;

/// Moves `X_WB` towards `target`, no surface point farther than `max_travel` (m); for bodies whose
/// motion is decided elsewhere. Gives the twist that this step was. Returns the travel made, m.
double Follow(RigidState& state, const Pose& target, double h, double radius,
              double max_travel) noexcept;

}  // namespace tandem
