#include "engine/dynamics/coupled_step.h"

#include <array>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "engine/dynamics/constraint.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::RandomDirection;
using testing::RandomRotation;
using testing::Uniform;

constexpr double kCoupledStep = 1e-3;

struct Bodies {
  std::array<Inertia, 4> inertias;
  std::array<RigidState, 4> states;
  std::array<LinearizedForce, 4> loads;
};

Bodies RandomBodies(std::mt19937_64& random, double turning) {
  Bodies bodies;
  for (std::size_t b = 0; b < 4; ++b) {
    const double mass = std::pow(10.0, Uniform(random, -2, 1));
    bodies.inertias[b] = {mass, 1e-4 * mass * Vec3(1, 2, 2.5).asDiagonal().toDenseMatrix()};
    bodies.states[b].X_WB = {RandomRotation(random), 0.02 * RandomDirection(random)};
    bodies.states[b].V_WB = {turning * RandomDirection(random), 0.2 * RandomDirection(random)};
  }
  return bodies;
}

/// Makes a contact between two bodies at a random place: what each gets, and how that changes.
CrossJacobian Touch(Bodies& bodies, std::size_t a, std::size_t b, std::mt19937_64& random) {
  CrossJacobian cross;
  for (int point = 0; point < 5; ++point) {
    const Vec3 p_W = 0.02 * RandomDirection(random);
    const Vec3 n = RandomDirection(random);
    Vec6 along_a;
    along_a << (p_W - bodies.states[a].X_WB.p).cross(n), n;
    Vec6 along_b;
    along_b << (p_W - bodies.states[b].X_WB.p).cross(n), n;
    const double stiffness = 1e5;
    const double damping = 300;
    const double closing =
        along_b.dot(Stacked(bodies.states[b].V_WB)) - along_a.dot(Stacked(bodies.states[a].V_WB));
    const double force = 2.0 + damping * closing;
    bodies.loads[a].force += force * along_a;
    bodies.loads[b].force -= force * along_b;
    bodies.loads[a].stiffness += stiffness * along_a * along_a.transpose();
    bodies.loads[b].stiffness += stiffness * along_b * along_b.transpose();
    bodies.loads[a].damping += damping * along_a * along_a.transpose();
    bodies.loads[b].damping += damping * along_b * along_b.transpose();
    cross.stiffness += stiffness * along_a * along_b.transpose();
    cross.damping += damping * along_a * along_b.transpose();
  }
  return cross;
}

// Bodies 0-1-3 push one another in a triangle, and 2 is not there; one of them turns about a hinge
// only. All unknowns in one dense matrix, with the forbidden ones left out, say the same.
TEST(CoupledStep, MatchesADenseSolve) {
  std::mt19937_64 random(51);
  for (int trial = 0; trial < 100; ++trial) {
    Bodies bodies = RandomBodies(random, 5.0);
    const Constraint hinge =
        HingeConstraint(bodies.states[1].X_WB, Vec3(0.01, 0, 0), RandomDirection(random));
    const Mat6 basis = AllowedBasis(hinge, bodies.states[1].X_WB);
    const std::array<std::array<std::size_t, 2>, 3> pairs{{{0, 1}, {3, 1}, {0, 3}}};
    std::array<CrossJacobian, 3> crosses;
    for (std::size_t k = 0; k < 3; ++k) {
      crosses[k] = Touch(bodies, pairs[k][0], pairs[k][1], random);
    }

    CoupledStep together(4);
    together.Begin();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(24, 24);
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(24);
    for (const std::size_t b : {3U, 0U, 1U}) {
      const StepEquations step =
          ImplicitEquations(bodies.inertias[b], bodies.states[b], bodies.loads[b], kCoupledStep);
      together.AddBody(b, step, bodies.states[b].V_WB, b == 1 ? basis : Mat6(Mat6::Identity()));
      A.block<6, 6>(6 * static_cast<int>(b), 6 * static_cast<int>(b)) = step.A;
      rhs.segment<6>(6 * static_cast<int>(b)) = step.b;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      together.Couple(pairs[k][0], pairs[k][1], crosses[k], kCoupledStep);
      const int a = 6 * static_cast<int>(pairs[k][0]);
      const int b = 6 * static_cast<int>(pairs[k][1]);
      const Mat6 change =
          kCoupledStep * crosses[k].damping + kCoupledStep * kCoupledStep * crosses[k].stiffness;
      A.block<6, 6>(a, b) -= change;
      A.block<6, 6>(b, a) -= change.transpose();
      rhs.segment<6>(a) -=
          kCoupledStep * crosses[k].damping * Stacked(bodies.states[pairs[k][1]].V_WB);
      rhs.segment<6>(b) -=
          kCoupledStep * crosses[k].damping.transpose() * Stacked(bodies.states[pairs[k][0]].V_WB);
    }
    together.Solve();

    Eigen::MatrixXd S = Eigen::MatrixXd::Zero(24, 13);  // columns of body 0, the hinge, body 3
    S.block<6, 6>(0, 0).setIdentity();
    S.block<6, 1>(6, 6) = basis.col(0);
    S.block<6, 6>(18, 7).setIdentity();
    const Eigen::VectorXd V =
        S * (S.transpose() * A * S).fullPivLu().solve(Eigen::VectorXd(S.transpose() * rhs));
    for (const std::size_t b : {0U, 1U, 3U}) {
      ASSERT_TRUE(together.has(b));
      const Vec6 found = Stacked(together.twist(b));
      EXPECT_LT((found - V.segment<6>(6 * static_cast<int>(b))).norm(), 1e-9) << "trial " << trial;
    }
    EXPECT_FALSE(together.has(2));
  }
}

// One body gets the momentum that the other loses, and its moment about W's origin. The bodies do
// not turn yet, so that I is the same at both ends of the step.
TEST(CoupledStep, ConservesLinearAndAngularMomentum) {
  std::mt19937_64 random(52);
  for (int trial = 0; trial < 200; ++trial) {
    Bodies bodies = RandomBodies(random, 0.0);
    const CrossJacobian cross = Touch(bodies, 0, 1, random);
    CoupledStep together(2);
    together.Begin();
    for (const std::size_t b : {0U, 1U}) {
      together.AddBody(
          b, ImplicitEquations(bodies.inertias[b], bodies.states[b], bodies.loads[b], kCoupledStep),
          bodies.states[b].V_WB, Mat6::Identity());
    }
    together.Couple(0, 1, cross, kCoupledStep);
    together.Solve();
    Vec3 momentum = Vec3::Zero();
    Vec3 moment = Vec3::Zero();
    double size = 0;
    for (const std::size_t b : {0U, 1U}) {
      const RigidState& state = bodies.states[b];
      const Inertia& inertia = bodies.inertias[b];
      const Vec3 gained = inertia.mass * (together.twist(b).v - state.V_WB.v);
      const Vec3 turned =
          state.X_WB.q * (inertia.I_B * (state.X_WB.q.conjugate() * together.twist(b).w));
      momentum += gained;
      moment += state.X_WB.p.cross(gained) + turned;
      size += gained.norm();
    }
    EXPECT_GT(size, 0.0);
    EXPECT_LT(momentum.norm(), 1e-10 * size) << "trial " << trial;
    EXPECT_LT(moment.norm(), 1e-11 * size) << "trial " << trial;
  }
}

TEST(CoupledStep, AllocatesNothing) {
  std::mt19937_64 random(53);
  Bodies bodies = RandomBodies(random, 1.0);
  const CrossJacobian cross = Touch(bodies, 0, 2, random);
  CoupledStep together(4);
  const testing::AllocationCounter counter;
  for (int frame = 0; frame < 10; ++frame) {
    together.Begin();
    for (const std::size_t b : {0U, 2U}) {
      together.AddBody(
          b, ImplicitEquations(bodies.inertias[b], bodies.states[b], bodies.loads[b], kCoupledStep),
          bodies.states[b].V_WB, Mat6::Identity());
    }
    together.Couple(0, 2, cross, kCoupledStep);
    together.Solve();
  }
  EXPECT_EQ(counter.count(), 0);
}

}  // namespace
}  // namespace tandem
