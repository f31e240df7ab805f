#include "engine/dynamics/virtual_coupling.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::RandomDirection;
using testing::RandomRotation;

const CouplingGains kGains{800, 8, 3.0 * Mat3::Identity(), 0.03 * Mat3::Identity()};

TEST(CouplingForce, IsZeroAtTheAnchor) {
  const RigidState body{{Quat::Identity(), Vec3(1, 2, 3)}, {}};
  const Pose X_BA{Quat::Identity(), Vec3(0.1, 0, 0)};
  EXPECT_NEAR(CouplingForce(kGains, body, X_BA, {body.X_WB * X_BA, {}}).force.norm(), 0.0, 1e-12);
}

TEST(CouplingForce, PullsTheGraspedPointToTheAnchor) {
  const RigidState body;
  const Pose X_BA{Quat::Identity(), Vec3(0.1, 0, 0)};
  const LinearizedForce load =
      CouplingForce(kGains, body, X_BA, {{Quat::Identity(), Vec3(0.1, 0.01, 0)}, {}});
  EXPECT_NEAR((load.force.tail<3>() - Vec3(0, 8.0, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((load.force.head<3>() - Vec3(0, 0, 0.8)).norm(), 0.0, 1e-12);  // lever 0.1 m
}

// Moved by a small twist d, the body feels the force change by -K d; sped up by it, by -D d. It is
// near the anchor, where the lever does not change the force's moment.
TEST(CouplingForce, ItsMatricesAreTheDerivativesOfItsForce) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const RigidState body{{RandomRotation(random), RandomDirection(random)}, {}};
    const Pose X_BA{RandomRotation(random), 0.1 * RandomDirection(random)};
    const Anchor anchor{body.X_WB * X_BA, {}};
    const LinearizedForce load = CouplingForce(kGains, body, X_BA, anchor);
    Vec6 d;
    d << RandomDirection(random), RandomDirection(random);
    constexpr double kStep = 1e-6;
    RigidState moved = body;
    moved.X_WB.p += kStep * d.tail<3>();
    moved.X_WB.q = RotationBy(kStep * d.head<3>()) * moved.X_WB.q;
    const Vec6 by_place = CouplingForce(kGains, moved, X_BA, anchor).force / kStep;
    EXPECT_NEAR((by_place + load.stiffness * d).norm(), 0.0, 1e-3 * load.stiffness.norm());
    RigidState faster = body;
    faster.V_WB = {d.head<3>(), d.tail<3>()};
    const Vec6 by_speed = CouplingForce(kGains, faster, X_BA, anchor).force;
    EXPECT_NEAR((by_speed + load.damping * d).norm(), 0.0, 1e-9);
  }
}

TEST(CentreCouplingForce, IsTheCouplingOfTheCentreBitForBit) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const auto twist = [&random] {
      return Twist{RandomDirection(random), RandomDirection(random)};
    };
    const RigidState body{{RandomRotation(random), RandomDirection(random)}, twist()};
    const Anchor anchor{{RandomRotation(random), RandomDirection(random)}, twist()};
    const Mat3 R = body.X_WB.q.toRotationMatrix();
    const Mat3 per_mass = R * Vec3(1e-3, 2e-3, 3e-3).asDiagonal() * R.transpose();
    const CouplingGains gains{310, 0.7, 310 * per_mass, 0.7 * per_mass};
    const LinearizedForce whole = CouplingForce(gains, body, Pose{}, anchor);
    const CentreForce centre = CentreCouplingForce(gains, body, anchor);
    LinearizedForce sum;
    centre.AddTo(sum);
    EXPECT_EQ(sum.force, whole.force);
    EXPECT_EQ(sum.stiffness, whole.stiffness);
    EXPECT_EQ(sum.damping, whole.damping);
    const Twist after = twist();
    const Wrench applied = AppliedWrench(centre, body.V_WB, after, 1e-3);
    const Wrench expected = AppliedWrench(whole, body.V_WB, after, 1e-3);
    EXPECT_EQ(applied.f, expected.f);
    EXPECT_EQ(applied.tau, expected.tau);
  }
}

TEST(CouplingForce, MomentIsBoundedBeyondHalfATurn) {
  const RigidState body;
  for (const double angle : {3.0, 3.13, 3.2, 4.0}) {
    const Anchor anchor{{RotationBy(Vec3(0, 0, angle)), Vec3::Zero()}, {}};
    const double moment = CouplingForce(kGains, body, Pose{}, anchor).force.head<3>().norm();
    EXPECT_LE(moment, 3.0 * M_PI + 1e-9);
  }
}

TEST(AppliedWrench, IsTheChangeOfMomentumWhenNothingElseActs) {
  std::mt19937_64 random(2);
  const Inertia inertia{0.3, Vec3(1e-4, 1e-4, 1e-4).asDiagonal()};  // no gyroscopic moment
  for (int trial = 0; trial < 50; ++trial) {
    RigidState body{{RandomRotation(random), Vec3::Zero()},
                    {RandomDirection(random), 0.1 * RandomDirection(random)}};
    const Pose X_BA{Quat::Identity(), 0.05 * RandomDirection(random)};
    const Anchor anchor{{RandomRotation(random), 0.05 * RandomDirection(random)}, {}};
    const LinearizedForce load = CouplingForce(kGains, body, X_BA, anchor);
    const Twist after = ImplicitTwist(inertia, body, load, 1e-3);
    const Wrench applied = AppliedWrench(load, body.V_WB, after, 1e-3);
    EXPECT_NEAR((inertia.mass * (after.v - body.V_WB.v) - 1e-3 * applied.f).norm(), 0.0, 1e-12);
    EXPECT_NEAR((1e-4 * (after.w - body.V_WB.w) - 1e-3 * applied.tau).norm(), 0.0, 1e-12);
  }
}

TEST(GroundDamping, TakesEnergyFromEveryMotion) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const RigidState body{{}, {RandomDirection(random), RandomDirection(random)}};
    const LinearizedForce load = GroundDamping(5.0, 0.01 * Mat3::Identity(), body);
    EXPECT_LT(load.force.dot(Stacked(body.V_WB)), 0.0);
  }
}

}  // namespace
}  // namespace tandem
