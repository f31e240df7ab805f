#include "engine/dynamics/virtual_coupling.h"

namespace tandem {

namespace {

/// Sets the matrix of a spring k at the lever r and a spring in rotation: J^T k J + rotation. J =
/// (-[r]x, 1) gives the velocity at r of (w, v).
void SetAtLever(double k, const Mat3& rotation, const Vec3& r, Mat6& matrix) {
  const Mat3 across = CrossMatrix(k * r);
  const Mat3 square = r * r.transpose();
  matrix.topLeftCorner<3, 3>() = rotation - k * square;
  matrix.topLeftCorner<3, 3>().diagonal().array() += k * r.squaredNorm();
  matrix.topRightCorner<3, 3>() = across;
  matrix.bottomLeftCorner<3, 3>() = -across;
  matrix.bottomRightCorner<3, 3>() = k * Mat3::Identity();
}

}  // namespace

LinearizedForce CouplingForce(const CouplingGains& gains, const RigidState& body, const Pose& X_BA,
                              const Anchor& anchor) noexcept {
  const Vec3 r = body.X_WB.q * X_BA.p;  // vector from the centre of mass to A
  const Quat q_WA = body.X_WB.q * X_BA.q;
  const Vec3 apart = anchor.X_WA.p - (body.X_WB.p + r);
  const Vec3 turned_apart = RotationVector(anchor.X_WA.q * q_WA.conjugate());
  const Vec3 v_A = body.V_WB.v + body.V_WB.w.cross(r);
  const Vec3 force = gains.stiffness * apart + gains.damping * (anchor.V_WA.v - v_A);
  LinearizedForce load;
  load.force << r.cross(force) + gains.rotation_stiffness * turned_apart +
                    gains.rotation_damping * (anchor.V_WA.w - body.V_WB.w),
      force;
  SetAtLever(gains.stiffness, gains.rotation_stiffness, r, load.stiffness);
  SetAtLever(gains.damping, gains.rotation_damping, r, load.damping);
  return load;
}

CentreForce CentreCouplingForce(const CouplingGains& gains, const RigidState& body,
                                const Anchor& anchor) noexcept {
  const Vec3 apart = anchor.X_WA.p - body.X_WB.p;
  const Vec3 turned_apart = RotationVector(anchor.X_WA.q * body.X_WB.q.conjugate());
  return {{gains.rotation_stiffness * turned_apart +
               gains.rotation_damping * (anchor.V_WA.w - body.V_WB.w),
           gains.stiffness * apart + gains.damping * (anchor.V_WA.v - body.V_WB.v)},
          gains};
}

void CentreForce::AddTo(LinearizedForce& load) const noexcept {
  load.force.head<3>() += F_B_W.tau;
  load.force.tail<3>() += F_B_W.f;
  load.stiffness.topLeftCorner<3, 3>() += gains.rotation_stiffness;
  load.stiffness.diagonal().tail<3>().array() += gains.stiffness;
  load.damping.topLeftCorner<3, 3>() += gains.rotation_damping;
  load.damping.diagonal().tail<3>().array() += gains.damping;
}

LinearizedForce GroundDamping(double damping, const Mat3& rotation_damping,
                              const RigidState& body) noexcept {
  LinearizedForce load;
  load.damping.topLeftCorner<3, 3>() = rotation_damping;
  load.damping.bottomRightCorner<3, 3>() = damping * Mat3::Identity();
  load.force << -(rotation_damping * body.V_WB.w), -damping * body.V_WB.v;
  return load;
}

Wrench AppliedWrench(const LinearizedForce& load, const Twist& before, const Twist& after,
                     double h) noexcept {
  const Vec6 v_new = Stacked(after);
  return AsWrench(load.force - h * load.stiffness * v_new -
                  load.damping * (v_new - Stacked(before)));
}

Wrench AppliedWrench(const CentreForce& load, const Twist& before, const Twist& after,
                     double h) noexcept {
  const CouplingGains& gains = load.gains;
  return {load.F_B_W.tau - (h * gains.rotation_stiffness) * after.w -
              gains.rotation_damping * (after.w - before.w),
          load.F_B_W.f - (h * gains.stiffness) * after.v - gains.damping * (after.v - before.v)};
}

CouplingGains DefaultHandGains(const Inertia& inertia) noexcept {
  constexpr double kStiffness = 800.0;  // N/m
  constexpr double kDamping = 8.0;      // N s/m
  // radius of gyration about the heavier axes: a slender part turns about its own axis as firmly as
  // across
  const double gyration_squared = 0.5 * inertia.I_B.trace() / inertia.mass;
  const Mat3 rotation = gyration_squared * Mat3::Identity();
  return {kStiffness, kDamping, kStiffness * rotation, kDamping * rotation};
}

}  // namespace tandem
