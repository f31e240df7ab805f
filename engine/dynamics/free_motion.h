#pragma once

#include <optional>

#include "engine/dynamics/axis_radii.h"
#include "engine/dynamics/constraint.h"
#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// Does Advance() for a body that no hand turns. Its moment of momentum turns it: rotation changes
/// neither that nor its energy. `constraint` may be nothing; about a ball joint the moment of
/// momentum is that about the joint. `V_WB` is the twist without gyroscopic moments. Returns
/// whether the travel limit held the body back.
bool AdvanceFreely(const Inertia& inertia, const std::optional<Constraint>& constraint,
                   RigidState& state, const Twist& V_WB, double h, const AxisRadii& radii,
                   double max_travel) noexcept;

/// Steps a body that only gravity pulls, `gravity_W` in m/s^2: half of the step's impulse before
/// the motion and half behind it. The step is exact in free fall, and of second order at a joint.
/// Returns whether the travel limit held it back.
bool Fly(const Inertia& inertia, const std::optional<Constraint>& constraint, RigidState& state,
         const Vec3& gravity_W, double h, const AxisRadii& radii, double max_travel) noexcept;

}  // namespace tandem
