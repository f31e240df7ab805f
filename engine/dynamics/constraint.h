#pragma once

#include <array>

#include "engine/base/linearized_force.h"
#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// A constraint that restricts a body's motion, as a developer sets it (paper fn. 1). It holds the
/// body at a frame J, fixed in the body, whose first pose in W is J0. J's origin may slide along
/// some of the axes of J0. J may turn freely, about the z axis of J0 only, or not at all.
///
/// ConstrainedTwist() solves the step for the remaining motions, and Advance() builds the pose in
/// each frame from J's slide and turn. So velocity and place are both exact: nothing drifts, and no
/// force has to correct anything.
struct Constraint {
  enum class Turn { kFree, kAboutAxis, kNone };

  std::array<bool, 3> slides{true, true, true};  // along x, y, z of J0
  Turn turn = Turn::kFree;
  Pose X_WJ0;
  Pose X_BJ;

  /// Returns the nearest pose of J in J0 that the constraint allows, without the forbidden parts.
  Pose Allowed(const Pose& X_J0J) const noexcept;
  /// Does the same for the body: for poses from elsewhere.
  Pose Nearest(const Pose& X_WB) const noexcept;
};

/// The body turns about an axis through `p_W` along `axis_W` (any length but 0) and has no other
/// motion. `X_WB0` is its first pose, here and below.
Constraint HingeConstraint(const Pose& X_WB0, const Vec3& p_W, const Vec3& axis_W);
/// The body slides along `axis_W` and does not turn.
Constraint SlideConstraint(const Pose& X_WB0, const Vec3& axis_W);
/// The body turns about the axis and slides along it.
Constraint CylinderConstraint(const Pose& X_WB0, const Vec3& p_W, const Vec3& axis_W);
/// The body's centre of mass stays in the plane across `normal_W`. The body may turn as `turn`
/// says, about the normal or otherwise.
Constraint PlaneConstraint(const Pose& X_WB0, const Vec3& normal_W, Constraint::Turn turn);
/// The body turns about the point `p_W` in any direction.
Constraint BallConstraint(const Pose& X_WB0, const Vec3& p_W);

/// Returns ImplicitEquations() for a constrained body.
StepEquations ConstrainedEquations(const Constraint& constraint, const Inertia& inertia,
                                   const RigidState& state, const LinearizedForce& load,
                                   double h) noexcept;
/// Returns the twists that the body may have, as columns; the other columns are zero.
Mat6 AllowedBasis(const Constraint& constraint, const Pose& X_WB) noexcept;

/// Returns ImplicitTwist() for a constrained body: among the allowed twists, the choice of Gauss'
/// principle of least constraint. The state's pose and twist must be allowed.
Twist ConstrainedTwist(const Constraint& constraint, const Inertia& inertia,
                       const RigidState& state, const LinearizedForce& load, double h) noexcept;

/// Does Advance() for a constrained body. The new pose is allowed to rounding, after any number of
/// steps. The new twist has the same rates of slide and turn at the new pose.
double Advance(const Constraint& constraint, RigidState& state, const Twist& V_WB, double h,
               double radius, double max_travel) noexcept;

/// Does Follow() for a constrained body, which stays within its constraint on the way.
double Follow(const Constraint& constraint, RigidState& state, const Pose& target, double h,
              double radius, double max_travel) noexcept;

}  // namespace tandem
