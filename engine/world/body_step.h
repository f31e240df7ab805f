#pragma once

#include "engine/dynamics/constraint.h"
#include "engine/dynamics/free_motion.h"
#include "engine/dynamics/rigid_body.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Moves a body after its mirror.
inline void FollowMirror(const BodyModel& model, RigidState& state, const Pose& target_WB,
                         const AxisRadii& radii, double max_travel) {
  if (model.constraint) {
    Follow(*model.constraint, state, target_WB, kFrame, radii.radius + radii.displaced, max_travel);
  } else {
    const Vec3 turn_B = RotationVector(state.X_WB.q.conjugate() * target_WB.q);
    Follow(state, target_WB, kFrame, radii.About(turn_B), max_travel);
  }
}

/// Returns the equations of a body's twist, for a system of several bodies.
/// `rolls`: no hand turns it, and StepFreely() will move it.
inline StepEquations EquationsOf(const BodyModel& model, const RigidState& state,
                                 const LinearizedForce& load, bool rolls) {
  if (!model.constraint && rolls) {
    return EquationsWithoutSpin(model.inertia, state, load, kFrame);
  }
  if (!model.constraint) return ImplicitEquations(model.inertia, state, load, kFrame);
  return ConstrainedEquations(*model.constraint, model.inertia, state, load, kFrame);
}

/// Returns the twist to which its load brings a body that pushes no other simulated body.
inline Twist TwistAlone(const BodyModel& model, const RigidState& state,
                        const LinearizedForce& load, bool rolls) {
  if (!model.constraint && rolls) {
    const StepEquations step = EquationsWithoutSpin(model.inertia, state, load, kFrame);
    const Vec6 V = step.A.ldlt().solve(step.b);
    return {V.head<3>(), V.tail<3>()};
  }
  if (!model.constraint) return ImplicitTwist(model.inertia, state, load, kFrame);
  return ConstrainedTwist(*model.constraint, model.inertia, state, load, kFrame);
}

/// Moves a body at a twist for a frame. `radius`: of its points as they are displaced, m. Returns
/// whether the travel limit held the body back.
inline bool StepBody(const BodyModel& model, RigidState& state, const Twist& desired, double radius,
                     double max_travel) {
  if (!model.constraint) {
    Advance(state, desired, kFrame, radius, max_travel);
    return state.V_WB.v != desired.v || state.V_WB.w != desired.w;
  }
  Advance(*model.constraint, state, desired, kFrame, radius, max_travel);
  // a joint turns the twist on the way, so only its size tells
  const bool turns = desired.w.norm() > 0;
  const double kept = turns ? state.V_WB.w.norm() : state.V_WB.v.norm();
  return kept < (1.0 - 1e-9) * (turns ? desired.w.norm() : desired.v.norm());
}

/// Moves a body that no hand turns for a frame: one that contact pushes at the twist that it brings
/// about, and any other by gravity alone. A body at a joint may have a twist that the joint does
/// not allow, as a peer sent it: its travel is counted from its centre. Returns whether the travel
/// limit held the body back.
inline bool StepFreely(const BodyModel& model, RigidState& state, const Twist& desired,
                       const Vec3* gravity_W, const AxisRadii& radii, double max_travel) {
  const double farthest = radii.radius + radii.displaced;
  if (gravity_W != nullptr) {
    return Fly(model.inertia, model.constraint, state, *gravity_W, kFrame,
               model.constraint ? AxisRadii::Ball(farthest) : radii, max_travel);
  }
  if (model.constraint) return StepBody(model, state, desired, farthest, max_travel);
  return AdvanceFreely(model.inertia, std::nullopt, state, desired, kFrame, radii, max_travel);
}

}  // namespace tandem
