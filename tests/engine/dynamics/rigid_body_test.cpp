#include "engine/dynamics/rigid_body.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::RandomDirection;
using testing::RandomRotation;
using testing::Uniform;

Inertia Brick() {
  return {0.3, Vec3(2e-4, 5e-4, 6e-4).asDiagonal()};
}

LinearizedForce Spring(const RigidState& state, double k, double b) {
  LinearizedForce load;
  load.force.tail<3>() = -k * state.X_WB.p - b * state.V_WB.v;
  load.stiffness.bottomRightCorner<3, 3>() = k * Mat3::Identity();
  load.damping.bottomRightCorner<3, 3>() = b * Mat3::Identity();
  return load;
}

double PlaceAfter(double seconds, double h, double k, double b) {
  RigidState state;
  state.X_WB.p = Vec3(0.01, 0, 0);
  const auto steps = std::lround(seconds / h);
  for (long i = 0; i < steps; ++i) {
    Advance(state, ImplicitTwist(Brick(), state, Spring(state, k, b), h), h, 0.1, 1e9);
  }
  return state.X_WB.p.x();
}

// x'' = -(k x + b x')/m from rest: the textbook's damped oscillation.
TEST(ImplicitTwist, HalvingTheStepHalvesTheError) {
  const double m = 0.3;
  const double k = 120;
  const double b = 2;
  const double t = 0.2;
  const double a = b / (2 * m);
  const double w = std::sqrt(k / m - a * a);
  const double exact = 0.01 * std::exp(-a * t) * (std::cos(w * t) + a / w * std::sin(w * t));
  const double coarse = std::abs(PlaceAfter(t, 1e-3, k, b) - exact);
  const double fine = std::abs(PlaceAfter(t, 5e-4, k, b) - exact);
  const double finer = std::abs(PlaceAfter(t, 2.5e-4, k, b) - exact);
  EXPECT_NEAR(coarse / fine, 2.0, 0.2);
  EXPECT_NEAR(fine / finer, 2.0, 0.1);
}

TEST(ImplicitTwist, IsStableForAnyStiffness) {
  for (const double k : {1e3, 1e6, 1e9, 1e12}) {
    RigidState state;
    state.X_WB.p = Vec3(0.001, 0, 0);
    double energy = 1e300;
    for (int i = 0; i < 200; ++i) {
      Advance(state, ImplicitTwist(Brick(), state, Spring(state, k, 0), 1e-3), 1e-3, 0.1, 1e9);
      const double now = 0.15 * state.V_WB.v.squaredNorm() + 0.5 * k * state.X_WB.p.squaredNorm();
      EXPECT_LE(now, energy * (1 + 1e-9) + 1e-300) << k;
      energy = now;
    }
  }
}

// A free brick spinning about its middle axis tumbles; its angular momentum stays.
TEST(ImplicitTwist, ConservesTheAngularMomentumOfATumblingBody) {
  const Inertia inertia = Brick();
  const auto momentum = [&](const RigidState& s) -> Vec3 {
    const Vec3 w_B = s.X_WB.q.conjugate() * s.V_WB.w;
    return s.X_WB.q * (inertia.I_B * w_B);
  };
  const auto drift = [&](double h) {
    RigidState state;
    state.V_WB.w = Vec3(0.1, 6.0, 0.05);
    const Vec3 first = momentum(state);
    for (int i = 0; i < static_cast<int>(1.0 / h); ++i) {
      Advance(state, ImplicitTwist(inertia, state, LinearizedForce{}, h), h, 0.1, 1e9);
    }
    return (momentum(state) - first).norm() / first.norm();
  };
  const double coarse = drift(1e-3);
  const double fine = drift(5e-4);
  EXPECT_LT(coarse, 0.05);
  EXPECT_NEAR(coarse / fine, 2.0, 0.5);
}

// Brute force: points all over the ball of the given radius.
TEST(Advance, NoPointGoesFartherThanAllowed) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    RigidState state{{RandomRotation(random), RandomDirection(random)}, {}};
    const Twist wanted{Uniform(random, 0, 4000) * RandomDirection(random),
                       Uniform(random, 0, 5) * RandomDirection(random)};
    const double radius = Uniform(random, 0, 0.3);
    const double limit = Uniform(random, 1e-6, 1e-3);
    const Pose before = state.X_WB;
    const double made = Advance(state, wanted, 1e-3, radius, limit);
    EXPECT_LE(made, limit);
    for (int i = 0; i < 50; ++i) {
      const Vec3 p_B = radius * RandomDirection(random);
      ASSERT_LE((state.X_WB * p_B - before * p_B).norm(), limit * (1 + 1e-9));
    }
    // a way that the body was not allowed is not remembered
    EXPECT_NEAR((state.X_WB.p - before.p - 1e-3 * state.V_WB.v).norm(), 0.0, 1e-15);
    EXPECT_LE(state.V_WB.v.norm(), wanted.v.norm() + 1e-12);
  }
}

TEST(Advance, SlowTwistIsUnchanged) {
  RigidState state;
  const Twist slow{Vec3(0.1, 0, 0), Vec3(0, 0.2, 0)};
  Advance(state, slow, 1e-3, 0.1, 5e-4);
  EXPECT_EQ(state.V_WB.v, slow.v);
  EXPECT_EQ(state.V_WB.w, slow.w);
}

TEST(Follow, ArrivesAndNeverGoesTooFast) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    RigidState state;
    const Pose target{RandomRotation(random), 0.05 * RandomDirection(random)};
    double left = 1e300;
    for (int i = 0; i < 4000 && left > 1e-9; ++i) {
      ASSERT_LE(Follow(state, target, 1e-3, 0.02, 2.5e-4), 2.5e-4);
      const double now = (state.X_WB.p - target.p).norm() +
                         0.02 * RotationVector(target.q * state.X_WB.q.conjugate()).norm();
      ASSERT_LE(now, left + 1e-9);
      left = now;
    }
    EXPECT_LT(left, 1e-9);
  }
}

// A twist or a target that is no number leaves the body where it was, at rest. The next sound one
// moves it again.
TEST(Advance, NonFiniteTwistDoesNotMoveTheBody) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Pose X_WB{RotationBy(Vec3(0.1, 0.2, 0.3)), Vec3(0.01, 0.02, 0.03)};
  for (const double bad : {kNaN, kInfinite, -kInfinite}) {
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      RigidState state{X_WB, {Vec3(1, 0, 0), Vec3(0, 1, 0)}};
      Vec6 V = Vec6::Zero();
      V[axis] = bad;
      EXPECT_EQ(Advance(state, {V.head<3>(), V.tail<3>()}, 1e-3, 0.1, 0.001), 0.0);
      EXPECT_EQ(state.X_WB.p, X_WB.p);
      EXPECT_EQ(state.X_WB.q.coeffs(), X_WB.q.coeffs());
      EXPECT_EQ(state.V_WB.v, Vec3::Zero());
      EXPECT_EQ(state.V_WB.w, Vec3::Zero());
    }
    RigidState state{X_WB, {}};
    Pose target = X_WB;
    target.p.x() = bad;
    Follow(state, target, 1e-3, 0.1, 0.001);
    EXPECT_EQ(state.X_WB.p, X_WB.p);
    target = X_WB;
    target.q.x() = bad;
    Follow(state, target, 1e-3, 0.1, 0.001);
    EXPECT_EQ(state.X_WB.q.coeffs(), X_WB.q.coeffs());
    target = X_WB;
    target.p.x() += 1e-4;
    Follow(state, target, 1e-3, 0.1, 0.001);
    EXPECT_NEAR(state.X_WB.p.x(), target.p.x(), 1e-12);
  }
}

}  // namespace
}  // namespace tandem
