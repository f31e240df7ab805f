#pragma once

#include <array>

#include "engine/base/load.h"
#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// What a developer's constraint leaves of a body's motion (paper fn. 1): it is held at a frame J,
/// fixed in the body, whose first pose in W is J0. J's origin may slide along some of the axes of
/// J0, and J may turn freely, about the z axis of J0 only, or not at all.
///
/// The step is solved for the motions that are left (ConstrainedTwist), and a pose is put together
/// again in each frame from J's slide and turn (Advance), so that velocity and place are both
/// exact: nothing drifts and no force has to bring anything back.
struct Constraint {
  enum class Turn { kFree, kAboutAxis, kNone };

  std::array<bool, 3> slides{true, true, true};  // along x, y, z of J0
  Turn turn = Turn::kFree;
  Pose X_WJ0;
  Pose X_BJ;

  /// The poses nearest to this one, of J in J0, that the constraint allows: what is forbidden is
  /// left out.
  Pose Allowed(const Pose& X_J0J) const noexcept;
  /// The same of the body: for poses from elsewhere.
  Pose Nearest(const Pose& X_WB) const noexcept;
};

/// The body turns about an axis through `p_W` along `axis_W` (any length but 0) and does nothing
/// else. `X_WB0` is its first pose, here and below.
Constraint HingeConstraint(const Pose& X_WB0, const Vec3& p_W, const Vec3& axis_W);
/// It slides along `axis_W` and does not turn.
Constraint SlideConstraint(const Pose& X_WB0, const Vec3& axis_W);
/// It turns about the axis and slides along it.
Constraint CylinderConstraint(const Pose& X_WB0, const Vec3& p_W, const Vec3& axis_W);
/// Its centre of mass stays in the plane across `normal_W`; it may turn as `turn` says, about the
/// normal or otherwise.
Constraint PlaneConstraint(const Pose& X_WB0, const Vec3& normal_W, Constraint::Turn turn);
/// It turns about the point `p_W` in any way.
Constraint BallConstraint(const Pose& X_WB0, const Vec3& p_W);

/// ImplicitEquations() of a constrained body.
StepEquations ConstrainedEquations(const Constraint& constraint, const Inertia& inertia,
                                   const RigidState& state, const Load& load, double h) noexcept;
/// The twists that it may have, as columns; the others are zero.
Mat6 AllowedBasis(const Constraint& constraint, const Pose& X_WB) noexcept;

/// ImplicitTwist() of a constrained body: of the twists that the constraint allows, the one that
/// Gauss' principle of least constraint picks. The state's pose and twist must be allowed ones.
Twist ConstrainedTwist(const Constraint& constraint, const Inertia& inertia,
                       const RigidState& state, const Load& load, double h) noexcept;

/// Advance() of a constrained body: the pose comes out allowed to rounding, whatever the number of
/// steps, and the new twist is the one that the same rates of slide and turn are there.
double Advance(const Constraint& constraint, RigidState& state, const Twist& V_WB, double h,
               double radius, double max_travel) noexcept;

/// Follow() of a constrained body, which stays within its constraint on the way.
double Follow(const Constraint& constraint, RigidState& state, const Pose& target, double h,
              double radius, double max_travel) noexcept;

}  // namespace tandem
