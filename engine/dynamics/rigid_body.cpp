#include "engine/dynamics/rigid_body.h"

#include <Eigen/Cholesky>

namespace tandem {

Twist ImplicitTwist(const Inertia& inertia, const RigidState& state, const Load& load,
                    double h) noexcept {
  const Mat3 R = state.X_WB.q.toRotationMatrix();
  const Mat3 I_W = R * inertia.I_B * R.transpose();
  const Vec6 v = Stacked(state.V_WB);
  Mat6 A = h * load.damping + h * h * load.stiffness;
  A.topLeftCorner<3, 3>() += I_W;
  A.bottomRightCorner<3, 3>() += inertia.mass * Mat3::Identity();
  Vec6 rhs = load.force - h * load.stiffness * v;
  rhs.head<3>() -= state.V_WB.w.cross(I_W * state.V_WB.w);
  const Vec6 v_new = v + A.ldlt().solve(h * rhs);
  return {v_new.head<3>(), v_new.tail<3>()};
}

double Advance(RigidState& state, const Twist& V_WB, double h, double radius,
               double max_travel) noexcept {
  const double wanted = TravelOf(h * V_WB.v, h * V_WB.w.norm(), radius);
  // |sin| is concave: scaling the twist scales the travel by at least as much, so a second look is
  // cheap
  double scale = wanted > max_travel ? max_travel / wanted : 1.0;
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
