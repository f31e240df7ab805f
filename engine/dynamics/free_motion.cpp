#include "engine/dynamics/free_motion.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace tandem {

namespace {

/// Parts in which a body at a ball joint makes a step. A spinning top nods quickly: in whole steps
/// its energy would go up and down by half a percent of what it exchanges.
constexpr int kPartsOfATop = 4;

/// The rotation of a step without a moment, W.
struct Spin {
  Vec3 mean;  // rad/s, of the whole step
  Vec3 end;   // rad/s, at its end
};

/// Turns a body about the mean of its angular velocities before and after the step, so that the
/// difference of both moments of momentum is across that mean: neither energy nor momentum changes.
Spin SpinWithoutMoment(const Mat3& I_B, const Quat& q_WB, const Vec3& w_W, double h) {
  constexpr int kMostRounds = 40;
  constexpr double kSettled = 1e-13;
  const Mat3 inverse = I_B.inverse();
  const Vec3 w_B = q_WB.conjugate() * w_W;
  const Vec3 before = I_B * w_B;  // moment of momentum in B
  Vec3 after = before;
  Vec3 mean = w_B;
  for (int round = 0; round < kMostRounds; ++round) {
    after = RotationBy(-h * mean) * before;
    const Vec3 better = 0.5 * (inverse * (before + after));
    const bool settled = (better - mean).norm() <= kSettled * w_B.norm();
    mean = better;
    if (settled) break;
  }
  after = RotationBy(-h * mean) * before;
  Vec3 end_B = inverse * after;
  // where so fast a rotation did not settle, energy must not rise
  const double energy = w_B.dot(before);
  const double risen = end_B.dot(after);
  if (risen > energy) end_B *= std::sqrt(energy / risen);
  return {q_WB * mean, q_WB * (RotationBy(h * mean) * end_B)};
}

/// Tells whether a joint holds one point of a body and lets it turn freely.
bool IsBallJoint(const Constraint& constraint) {
  return constraint.turn == Constraint::Turn::kFree && !constraint.slides[0] &&
         !constraint.slides[1] && !constraint.slides[2];
}

/// Changes a twist by the impulse of a force at the centre of mass, within the allowed twists.
void Push(const Inertia& inertia, const std::optional<Constraint>& constraint, RigidState& state,
          const Vec3& impulse_W) {
  if (!constraint) {
    state.V_WB.v += impulse_W / inertia.mass;
    return;
  }
  const Mat3 R = state.X_WB.q.toRotationMatrix();
  Mat6 M = Mat6::Zero();
  M.topLeftCorner<3, 3>() = R * inertia.I_B * R.transpose();
  M.bottomRightCorner<3, 3>() = inertia.mass * Mat3::Identity();
  const Mat6 S = AllowedBasis(*constraint, state.X_WB);
  Mat6 A = S.transpose() * M * S;
  for (Eigen::Index i = 0; i < 6; ++i) {
    if (S.col(i).isZero(0)) A(i, i) = 1.0;
  }
  Vec6 impulse = Vec6::Zero();
  impulse.tail<3>() = impulse_W;
  const Vec6 change = S * A.ldlt().solve(S.transpose() * impulse);
  state.V_WB.w += change.head<3>();
  state.V_WB.v += change.tail<3>();
}

}  // namespace

bool AdvanceFreely(const Inertia& inertia, const std::optional<Constraint>& constraint,
                   RigidState& state, const Twist& V_WB, double h, const AxisRadii& radii,
                   double max_travel) noexcept {
  const auto advance = [&](const Twist& twist) {
    const double radius = radii.About(state.X_WB.q.conjugate() * twist.w);
    if (!constraint) {
      Advance(state, twist, h, radius, max_travel);
      return state.V_WB.v != twist.v || state.V_WB.w != twist.w;
    }
    Advance(*constraint, state, twist, h, radius, max_travel);
    // a joint turns the twist on the way, so only its size tells
    const bool turns = twist.w.norm() > 0;
    const double kept = turns ? state.V_WB.w.norm() : state.V_WB.v.norm();
    return kept < (1.0 - 1e-9) * (turns ? twist.w.norm() : twist.v.norm());
  };
  const bool free_to_turn = !constraint || constraint->turn == Constraint::Turn::kFree;
  if (!free_to_turn || !V_WB.v.allFinite() || !V_WB.w.allFinite()) return advance(V_WB);
  const bool at_joint = constraint && IsBallJoint(*constraint);
  const Vec3 lever_B = at_joint ? Vec3(-constraint->X_BJ.p) : Vec3::Zero();
  const Mat3 I_B = inertia.I_B + inertia.mass * (lever_B.squaredNorm() * Mat3::Identity() -
                                                 lever_B * lever_B.transpose());
  const Spin spin = SpinWithoutMoment(I_B, state.X_WB.q, V_WB.w, h);
  Twist mean{spin.mean, V_WB.v};
  if (at_joint) mean.v = spin.mean.cross(state.X_WB.q * lever_B);
  // a body that is held back goes on at the twist that it is allowed
  if (advance(mean)) return true;
  state.V_WB.w = spin.end;
  if (at_joint) state.V_WB.v = spin.end.cross(state.X_WB.q * lever_B);
  return false;
}

bool Fly(const Inertia& inertia, const std::optional<Constraint>& constraint, RigidState& state,
         const Vec3& gravity_W, double h, const AxisRadii& radii, double max_travel) noexcept {
  const int parts = constraint && IsBallJoint(*constraint) ? kPartsOfATop : 1;
  const Vec3 half = 0.5 * h / parts * inertia.mass * gravity_W;
  bool held = false;
  for (int part = 0; part < parts; ++part) {
    Push(inertia, constraint, state, half);
    const Twist wanted = state.V_WB;
    held = AdvanceFreely(inertia, constraint, state, wanted, h / parts, radii, max_travel / parts);
    if (!held) Push(inertia, constraint, state, half);
  }
  if (held) return true;
  // a body that the limit would hold back in the next step does not gather speed meanwhile
  const double radius = radii.About(state.X_WB.q.conjugate() * state.V_WB.w);
  const double next = TravelOf(h * state.V_WB.v, h * state.V_WB.w.norm(), radius);
  if (next <= max_travel) return false;
  state.V_WB = {max_travel / next * state.V_WB.w, max_travel / next * state.V_WB.v};
  return true;
}

}  // namespace tandem
