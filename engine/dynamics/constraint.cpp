#include "engine/dynamics/constraint.h"

#include <cmath>

#include <Eigen/LU>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// The motion of J in J0: in these coordinates a constraint is a choice of axes.
struct JointRates {
  Vec3 turn;   // rad/s
  Vec3 slide;  // m/s
};

/// Returns the vector from J's origin to the centre of mass, in W.
Vec3 Lever(const Constraint& constraint, const Pose& X_WB) {
  return -(X_WB.q * constraint.X_BJ.p);
}

JointRates RatesOf(const Constraint& constraint, const Pose& X_WB, const Twist& V_WB) {
  const Quat q_J0W = constraint.X_WJ0.q.conjugate();
  JointRates rates{q_J0W * V_WB.w, q_J0W * (V_WB.v - V_WB.w.cross(Lever(constraint, X_WB)))};
  if (constraint.turn == Constraint::Turn::kNone) rates.turn.setZero();
  if (constraint.turn == Constraint::Turn::kAboutAxis) rates.turn.head<2>().setZero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!constraint.slides[static_cast<std::size_t>(i)]) rates.slide[i] = 0;
  }
  return rates;
}

Twist TwistOf(const Constraint& constraint, const Pose& X_WB, const JointRates& rates) {
  const Vec3 w = constraint.X_WJ0.q * rates.turn;
  return {w, constraint.X_WJ0.q * rates.slide + w.cross(Lever(constraint, X_WB))};
}

Pose InJoint(const Constraint& constraint, const Pose& X_WB) {
  return constraint.X_WJ0.Inverse() * X_WB * constraint.X_BJ;
}

Pose InWorld(const Constraint& constraint, const Pose& X_J0J) {
  Pose X_WB = constraint.X_WJ0 * X_J0J * constraint.X_BJ.Inverse();
  X_WB.q.normalize();
  return X_WB;
}

/// The allowed twists at a pose, as columns, J's turns first.
using Directions = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;
Directions AllowedTwists(const Constraint& constraint, const Pose& X_WB) {
  Directions S(6, 6);
  Eigen::Index count = 0;
  const Mat3 axes = constraint.X_WJ0.q.toRotationMatrix();
  const Vec3 lever = Lever(constraint, X_WB);
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (constraint.turn == Constraint::Turn::kNone) break;
    if (constraint.turn == Constraint::Turn::kAboutAxis && i < 2) continue;
    S.col(count++) << axes.col(i), axes.col(i).cross(lever);
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!constraint.slides[static_cast<std::size_t>(i)]) continue;
    S.col(count++) << Vec3::Zero(), axes.col(i);
  }
  S.conservativeResize(6, count);
  return S;
}

Constraint At(const Pose& X_WB0, const Vec3& p_W, const Vec3& axis_W) {
  TANDEM_CHECK(axis_W.norm() > 0);
  Constraint constraint;
  constraint.X_WJ0 = {Quat::FromTwoVectors(Vec3::UnitZ(), axis_W.normalized()).normalized(), p_W};
  constraint.X_BJ = X_WB0.Inverse() * constraint.X_WJ0;
  return constraint;
}

}  // namespace

Pose Constraint::Allowed(const Pose& X_J0J) const noexcept {
  Pose allowed = X_J0J;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!slides[static_cast<std::size_t>(i)]) allowed.p[i] = 0;
  }
  if (turn == Turn::kFree) return allowed;
  // the part about z of a rotation q has the direction (0, 0, q.z, q.w)
  const double length = std::hypot(X_J0J.q.z(), X_J0J.q.w());
  const bool kept = turn == Turn::kAboutAxis && length > 0;
  allowed.q = kept ? Quat(X_J0J.q.w() / length, 0, 0, X_J0J.q.z() / length) : Quat::Identity();
  return allowed;
}

Pose Constraint::Nearest(const Pose& X_WB) const noexcept {
  return InWorld(*this, Allowed(InJoint(*this, X_WB)));
}

Constraint HingeConstraint(const Pose& X_WB0, const Vec3& p_W, const Vec3& axis_W) {
  Constraint hinge = At(X_WB0, p_W, axis_W);
  hinge.slides = {false, false, false};
  hinge.turn = Constraint::Turn::kAboutAxis;
  return hinge;
}

Constraint SlideConstraint(const Pose& X_WB0, const Vec3& axis_W) {
  Constraint slide = At(X_WB0, X_WB0.p, axis_W);
  slide.slides = {false, false, true};
  slide.turn = Constraint::Turn::kNone;
  return slide;
}

Constraint CylinderConstraint(const Pose& X_WB0, const Vec3& p_W, const Vec3& axis_W) {
  Constraint cylinder = HingeConstraint(X_WB0, p_W, axis_W);
  cylinder.slides[2] = true;
  return cylinder;
}

Constraint PlaneConstraint(const Pose& X_WB0, const Vec3& normal_W, Constraint::Turn turn) {
  Constraint plane = At(X_WB0, X_WB0.p, normal_W);
  plane.slides = {true, true, false};
  plane.turn = turn;
  return plane;
}

Constraint BallConstraint(const Pose& X_WB0, const Vec3& p_W) {
  Constraint ball = At(X_WB0, p_W, Vec3::UnitZ());
  ball.slides = {false, false, false};
  return ball;
}

StepEquations ConstrainedEquations(const Constraint& constraint, const Inertia& inertia,
                                   const RigidState& state, const LinearizedForce& load,
                                   double h) noexcept {
  StepEquations step = ImplicitEquations(inertia, state, load, h);
  // the centre of mass circles J: m w x (w' x r) with the new w', which does no work on w'
  const Vec3 lever = Lever(constraint, state.X_WB);
  step.A.bottomLeftCorner<3, 3>() -=
      h * inertia.mass * CrossMatrix(state.V_WB.w) * CrossMatrix(lever);
  return step;
}

Mat6 AllowedBasis(const Constraint& constraint, const Pose& X_WB) noexcept {
  const Directions S = AllowedTwists(constraint, X_WB);
  Mat6 basis = Mat6::Zero();
  basis.leftCols(S.cols()) = S;
  return basis;
}

Twist ConstrainedTwist(const Constraint& constraint, const Inertia& inertia,
                       const RigidState& state, const LinearizedForce& load, double h) noexcept {
  const Directions S = AllowedTwists(constraint, state.X_WB);
  const StepEquations step = ConstrainedEquations(constraint, inertia, state, load, h);
  using Reduced = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  using Rates = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
  const Directions AS = step.A * S;
  const Reduced reduced = S.transpose() * AS;
  const Rates rhs = S.transpose() * step.b;
  const Rates rates = reduced.partialPivLu().solve(rhs);
  const Vec6 V = S * rates;
  return {V.head<3>(), V.tail<3>()};
}

double Advance(const Constraint& constraint, RigidState& state, const Twist& V_WB, double h,
               double radius, double max_travel) noexcept {
  constexpr int kMostQueries = 8;
  if (!V_WB.v.allFinite() || !V_WB.w.allFinite()) {
    state.V_WB = {};
    return 0;
  }
  const JointRates wanted = RatesOf(constraint, state.X_WB, V_WB);
  const Pose X_J0J = constraint.Allowed(InJoint(constraint, state.X_WB));
  double scale = 1.0;
  // usually one look, two where the travel is limited; a limit as small as rounding stops the body
  for (int look = 0; look < kMostQueries; ++look) {
    const JointRates rates{scale * wanted.turn, scale * wanted.slide};
    const Pose next{RotationBy(h * rates.turn) * X_J0J.q, X_J0J.p + h * rates.slide};
    const Pose X_WB = InWorld(constraint, constraint.Allowed(next));
    const double made = TravelOf(X_WB.p - state.X_WB.p, h * rates.turn.norm(), radius);
    if (made <= max_travel) {
      state.X_WB = X_WB;
      state.V_WB = TwistOf(constraint, X_WB, rates);
      return made;
    }
    scale *= 0.999 * max_travel / made;
  }
  state.V_WB = {};
  return 0;
}

double Follow(const Constraint& constraint, RigidState& state, const Pose& target, double h,
              double radius, double max_travel) noexcept {
  const Pose here = constraint.Allowed(InJoint(constraint, state.X_WB));
  const Pose there = constraint.Allowed(InJoint(constraint, target));
  const JointRates whole{RotationVector(there.q * here.q.conjugate()) / h, (there.p - here.p) / h};
  return Advance(constraint, state, TwistOf(constraint, state.X_WB, whole), h, radius, max_travel);
}

}  // namespace tandem
