#include "engine/dynamics/rigid_body.h"

#include <Eigen/LU>

namespace tandem {

namespace {

Mat3 InertiaInW(const Inertia& inertia, const RigidState& state) {
  const Mat3 R = state.X_WB.q.toRotationMatrix();
  return R * inertia.I_B * R.transpose();
}

StepEquations EquationsOfLoad(const Inertia& inertia, const Mat3& I_W, const RigidState& state,
                              const LinearizedForce& load, double h) {
  StepEquations step;
  Mat6 M = Mat6::Zero();
  M.topLeftCorner<3, 3>() = I_W;
  M.bottomRightCorner<3, 3>() = inertia.mass * Mat3::Identity();
  M += h * load.damping;
  step.A = M + h * h * load.stiffness;
  step.b = M * Stacked(state.V_WB) + h * load.force;
  return step;
}

}  // namespace

StepEquations EquationsWithoutSpin(const Inertia& inertia, const RigidState& state,
                                   const LinearizedForce& load, double h) noexcept {
  return EquationsOfLoad(inertia, InertiaInW(inertia, state), state, load, h);
}

StepEquations ImplicitEquations(const Inertia& inertia, const RigidState& state,
                                const LinearizedForce& load, double h) noexcept {
  const Mat3 I_W = InertiaInW(inertia, state);
  StepEquations step = EquationsOfLoad(inertia, I_W, state, load, h);
  // w x I w = w x (I - c) w for any number c: with this c it is 0 for a ball, as it must be
  const Vec3 uneven = I_W * state.V_WB.w - (I_W.trace() / 3.0) * state.V_WB.w;
  step.A.topLeftCorner<3, 3>() -= h * CrossMatrix(uneven);
  return step;
}

Twist ImplicitTwist(const Inertia& inertia, const RigidState& state, const LinearizedForce& load,
                    double h) noexcept {
  const StepEquations step = ImplicitEquations(inertia, state, load, h);
  const Vec6 V = step.A.partialPivLu().solve(step.b);
  return {V.head<3>(), V.tail<3>()};
}

double Advance(RigidState& state, const Twist& V_WB, double h, double radius,
               double max_travel) noexcept {
  if (!V_WB.v.allFinite() || !V_WB.w.allFinite()) {
    state.V_WB = {};
    return 0;
  }
  const double desired = TravelOf(h * V_WB.v, h * V_WB.w.norm(), radius);
  // |sin| is concave: scaling the twist scales the travel by at least as much, so a second look is
  // cheap
  double scale = desired > max_travel ? max_travel / desired : 1.0;
  double made = TravelOf(scale * h * V_WB.v, scale * h * V_WB.w.norm(), radius);
  while (made > max_travel) {
    scale *= 0.999 * max_travel / made;
    made = TravelOf(scale * h * V_WB.v, scale * h * V_WB.w.norm(), radius);
  }
  state.V_WB = {scale * V_WB.w, scale * V_WB.v};
  state.X_WB.p += h * state.V_WB.v;
  state.X_WB.q = (RotationBy(h * state.V_WB.w) * state.X_WB.q).normalized();
  return made;
}

double Follow(RigidState& state, const Pose& target, double h, double radius,
              double max_travel) noexcept {
  const Vec3 turn = RotationVector(target.q * state.X_WB.q.conjugate());
  const Twist whole{turn / h, (target.p - state.X_WB.p) / h};
  return Advance(state, whole, h, radius, max_travel);
}

}  // namespace tandem
