#pragma once

#include "engine/base/linearized_force.h"
#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// The pose that a coupling pulls a body to, and its motion: a hand's goal, or another user's copy
/// of the body (paper §6.1).
struct Anchor {
  Pose X_WA;
  Twist V_WA;
};

/// Springs and dampers in six dimensions.
struct CouplingGains {
  double stiffness = 0;                    // N/m
  double damping = 0;                      // damping of the relative velocity, N s/m
  Mat3 rotation_stiffness = Mat3::Zero();  // N m/rad, in W
  Mat3 rotation_damping = Mat3::Zero();    // N m s/rad, in W
};

/// Returns the load that pulls frame A' of a body (at X_BA) towards an anchor: a force at A's
/// origin and a moment, with their change as the body moves. Beyond half a turn the moment does not
/// grow.
LinearizedForce CouplingForce(const CouplingGains& gains, const RigidState& body, const Pose& X_BA,
                              const Anchor& anchor) noexcept;

/// A coupling at the centre of mass, whose change with the body's motion is that of its gains. It
/// gives the bits of CouplingForce() there at a quarter of the cost.
struct CentreForce {
  Wrench F_B_W;
  CouplingGains gains;

  void AddTo(LinearizedForce& load) const noexcept;
};
CentreForce CentreCouplingForce(const CouplingGains& gains, const RigidState& body,
                                const Anchor& anchor) noexcept;

/// Returns the damping towards the ground, at the centre of mass.
LinearizedForce GroundDamping(double damping, const Mat3& rotation_damping,
                              const RigidState& body) noexcept;

/// Returns the wrench that a load really applied over an implicit step that changed the body's
/// twist from `before` to `after`: its value at the end of the step. A device must render this
/// wrench (docs/decisions/0004-contact-and-step.md).
Wrench AppliedWrench(const LinearizedForce& load, const Twist& before, const Twist& after,
                     double h) noexcept;
Wrench AppliedWrench(const CentreForce& load, const Twist& before, const Twist& after,
                     double h) noexcept;

/// Returns the gains of the hand's coupling: 800 N/m with 8 N s/m, and in rotation the same at the
/// body's radius of gyration.
CouplingGains DefaultHandGains(const Inertia& inertia) noexcept;

}  // namespace tandem
