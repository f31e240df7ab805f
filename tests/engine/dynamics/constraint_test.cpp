#include "engine/dynamics/constraint.h"

#include <functional>
#include <limits>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "tests/engine/dynamics/runge_kutta.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::QuatRate;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::RungeKutta;
using testing::Uniform;

constexpr double kStep = 1e-3;  // s
constexpr double kNoLimit = 1e9;

Inertia HalfBrick() {
  return {0.3, Vec3(2e-4, 5e-4, 6e-4).asDiagonal()};
}

/// A constraint, and its fault told in another way: how far a pose is from allowed (m or rad), from
/// the places of points of the body alone.
struct Kind {
  const char* name;
  Constraint constraint;
  std::function<double(const Pose& X_WB)> fault;
};

const Pose kFirst{RotationBy(Vec3(0.3, -0.2, 0.9)), Vec3(0.4, 0.1, -0.2)};
const Vec3 kPlace = kFirst.p + Vec3(0.05, -0.02, 0.03);
const Vec3 kAxis(0.6, 0, 0.8);

/// Returns how far a point of the body, `p_W` at first, is from there.
Vec3 Moved(const Pose& X_WB, const Vec3& p_W) {
  return X_WB * (kFirst.Inverse() * p_W) - p_W;
}

Vec3 PerpendicularTo(const Vec3& v) {
  return v - v.dot(kAxis) * kAxis;
}

std::vector<Kind> Kinds() {
  const auto turned = [](const Pose& X_WB) {
    return RotationVector(X_WB.q * kFirst.q.conjugate()).norm();
  };
  const auto axis_tilt = [](const Pose& X_WB) {
    return (X_WB.q * (kFirst.q.conjugate() * kAxis) - kAxis).norm();
  };
  return {
      {"hinge", HingeConstraint(kFirst, kPlace, 3.0 * kAxis),
       [](const Pose& X) {
         return Moved(X, kPlace).norm() + Moved(X, kPlace + kAxis).norm();
       }},
      {"slide", SlideConstraint(kFirst, kAxis),
       [=](const Pose& X) {
         return PerpendicularTo(Moved(X, kPlace)).norm() + turned(X);
       }},
      {"cylinder", CylinderConstraint(kFirst, kPlace, kAxis),
       [](const Pose& X) {
         return PerpendicularTo(Moved(X, kPlace)).norm() +
                PerpendicularTo(Moved(X, kPlace + kAxis)).norm();
       }},
      {"plane", PlaneConstraint(kFirst, kAxis, Constraint::Turn::kAboutAxis),
       [=](const Pose& X) {
         return std::abs(Moved(X, kPlace).dot(kAxis)) + axis_tilt(X);
       }},
      {"plane, no turn", PlaneConstraint(kFirst, kAxis, Constraint::Turn::kNone),
       [=](const Pose& X) {
         return std::abs(Moved(X, kPlace).dot(kAxis)) + turned(X);
       }},
      {"plane, free turn", PlaneConstraint(kFirst, kAxis, Constraint::Turn::kFree),
       [](const Pose& X) {
         return std::abs(Moved(X, kFirst.p).dot(kAxis));
       }},
      {"ball", BallConstraint(kFirst, kPlace),
       [](const Pose& X) {
         return Moved(X, kPlace).norm();
       }},
  };
}

double KineticEnergy(const Inertia& inertia, const RigidState& state) {
  const Vec3 w_B = state.X_WB.q.conjugate() * state.V_WB.w;
  return 0.5 * inertia.mass * state.V_WB.v.squaredNorm() + 0.5 * w_B.dot(inertia.I_B * w_B);
}

// 100 s of pushes and moments in any direction, stiff at times, with and without a travel limit.
TEST(Constraint, DoesNotDriftInAHundredThousandFramesOfShaking) {
  for (const Kind& kind : Kinds()) {
    std::mt19937_64 random(1);
    RigidState state{kFirst, {}};
    LinearizedForce load;
    double farthest = 0;
    double most_turned = 0;
    for (int frame = 0; frame < 100'000; ++frame) {
      if (frame % 50 == 0) {
        load.force << 0.3 * RandomDirection(random), 5.0 * RandomDirection(random);
        const double stiffness = std::pow(10.0, Uniform(random, 0, 6));
        load.stiffness = (frame % 100 == 0 ? stiffness : 0.0) * Mat6::Identity();
      }
      LinearizedForce acting = load;
      acting.force -= 0.02 * Stacked(state.V_WB);
      acting.damping += 0.02 * Mat6::Identity();
      const Twist V = ConstrainedTwist(kind.constraint, HalfBrick(), state, acting, kStep);
      Advance(kind.constraint, state, V, kStep, 0.1, frame % 3000 < 1000 ? 5e-4 : kNoLimit);
      ASSERT_LT(kind.fault(state.X_WB), 1e-9) << kind.name << " in frame " << frame;
      farthest = std::max(farthest, (state.X_WB.p - kFirst.p).norm());
      most_turned =
          std::max(most_turned, RotationVector(state.X_WB.q * kFirst.q.conjugate()).norm());
    }
    // the body was shaken: the free motions moved
    EXPECT_GT(farthest + most_turned, 0.1) << kind.name;
  }
}

TEST(Constraint, ProjectedTwistsKeepThePoseAllowed) {
  for (const Kind& kind : Kinds()) {
    std::mt19937_64 random(2);
    RigidState state{kFirst, {}};
    for (int frame = 0; frame < 300; ++frame) {
      LinearizedForce load;
      load.force << RandomDirection(random), 20.0 * RandomDirection(random);
      const Twist V = ConstrainedTwist(kind.constraint, HalfBrick(), state, load, kStep);
      // moved on by the bare twist for a very short while, the fault is of second order
      RigidState moved = state;
      Advance(moved, V, 1e-6, 0, kNoLimit);
      const double size = 1e-6 * (V.w.norm() + V.v.norm());
      EXPECT_LT(kind.fault(moved.X_WB), 10.0 * size * size + 1e-14) << kind.name;
      Advance(kind.constraint, state, V, kStep, 0.1, kNoLimit);
    }
  }
}

// The oracle: a free body with dampers of 1e9 N s/m on every forbidden motion, told by the fault of
// the pose that the motion leads to.
TEST(Constraint, EqualsUnboundedDampersOnForbiddenMotion) {
  const Inertia brick = HalfBrick();
  for (const Kind& kind : Kinds()) {
    std::mt19937_64 random(3);
    const RigidState at_rest{kFirst, {}};
    // the allowed directions, found by trying: twists that ConstrainedTwist leaves as they are
    Mat6 allowed = Mat6::Zero();
    for (int i = 0; i < 60; ++i) {
      RigidState moving = at_rest;
      Vec6 d;
      d << RandomDirection(random), 0.1 * RandomDirection(random);
      const Vec3 w = d.head<3>();
      moving.V_WB = {w, d.tail<3>()};
      const Vec6 kept = Stacked(ConstrainedTwist(kind.constraint, brick, moving, {}, 1e-9));
      allowed += kept * kept.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Mat6> spectrum(allowed);
    Mat6 forbidden = Mat6::Zero();
    for (Eigen::Index i = 0; i < 6; ++i) {
      if (spectrum.eigenvalues()[i] < 1e-9 * spectrum.eigenvalues()[5]) {
        forbidden += spectrum.eigenvectors().col(i) * spectrum.eigenvectors().col(i).transpose();
      }
    }
    for (int trial = 0; trial < 20; ++trial) {
      LinearizedForce load;
      load.force << RandomDirection(random), 20.0 * RandomDirection(random);
      const Mat6 root = Mat6::NullaryExpr([&] {
        return Uniform(random, -1, 1);
      });
      load.stiffness = 1e3 * root * root.transpose();
      const Vec6 V = Stacked(ConstrainedTwist(kind.constraint, brick, at_rest, load, kStep));
      load.damping += 1e9 * forbidden;
      const Vec6 damped = Stacked(ImplicitTwist(brick, at_rest, load, kStep));
      EXPECT_LT((V - damped).norm(), 1e-6 * damped.norm() + 1e-7) << kind.name;
    }
  }
}

TEST(Constraint, FreeConstraintChangesNothing) {
  std::mt19937_64 random(4);
  Constraint none;
  none.X_WJ0 = {RandomRotation(random), RandomDirection(random)};
  none.X_BJ = kFirst.Inverse() * none.X_WJ0;
  none.X_BJ.p.setZero();  // at the centre of mass: elsewhere J's own inertia comes in
  RigidState free{kFirst, {Vec3(1, 2, 3), Vec3(0.1, 0.2, 0.3)}};
  RigidState constrained = free;
  for (int frame = 0; frame < 200; ++frame) {
    LinearizedForce load;
    load.force << 0.1 * RandomDirection(random), 5.0 * RandomDirection(random);
    Advance(free, ImplicitTwist(HalfBrick(), free, load, kStep), kStep, 0.1, kNoLimit);
    Advance(none, constrained, ConstrainedTwist(none, HalfBrick(), constrained, load, kStep), kStep,
            0.1, kNoLimit);
  }
  EXPECT_LT((free.X_WB.p - constrained.X_WB.p).norm(), 1e-10);
  EXPECT_LT((free.V_WB.w - constrained.V_WB.w).norm(), 1e-9);
}

TEST(Constraint, NoPointGoesFartherThanAllowed) {
  for (const Kind& kind : Kinds()) {
    std::mt19937_64 random(5);
    RigidState state{kFirst, {}};
    for (int trial = 0; trial < 200; ++trial) {
      const Twist wanted{Uniform(random, 0, 1000) * RandomDirection(random),
                         Uniform(random, 0, 5) * RandomDirection(random)};
      const double radius = Uniform(random, 0, 0.3);
      const double limit = Uniform(random, 1e-6, 1e-3);
      const Pose before = state.X_WB;
      EXPECT_LE(Advance(kind.constraint, state, wanted, kStep, radius, limit), limit);
      for (int i = 0; i < 50; ++i) {
        const Vec3 p_B = radius * RandomDirection(random);
        ASSERT_LE((state.X_WB * p_B - before * p_B).norm(), limit * (1 + 1e-9)) << kind.name;
      }
    }
  }
}

TEST(Constraint, StopsWithoutRemainingTravel) {
  for (const Kind& kind : Kinds()) {
    RigidState state{kFirst, {}};
    EXPECT_EQ(Advance(kind.constraint, state, {Vec3(1, 2, 3), Vec3(1, 2, 3)}, kStep, 0.1, 0.0),
              0.0);
    EXPECT_LT((state.X_WB.p - kFirst.p).norm(), 1e-15) << kind.name;
  }
}

TEST(Constraint, NonFiniteTwistDoesNotMoveTheBody) {
  for (const Kind& kind : Kinds()) {
    RigidState state{kFirst, {Vec3(1, 0, 0), Vec3(0, 1, 0)}};
    const Vec3 none = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(Advance(kind.constraint, state, {none, none}, kStep, 0.1, 1e-3), 0.0) << kind.name;
    Follow(kind.constraint, state, {kFirst.q, none}, kStep, 0.1, 1e-3);
    EXPECT_LT((state.X_WB.p - kFirst.p).norm(), 1e-12) << kind.name;
    EXPECT_LT(state.X_WB.q.angularDistance(kFirst.q), 1e-7) << kind.name;
    EXPECT_LT(state.V_WB.v.norm(), 1e-9) << kind.name;
    EXPECT_LT(state.V_WB.w.norm(), 1e-9) << kind.name;
  }
}

TEST(Constraint, FollowArrivesAndStaysAllowedOnTheWay) {
  for (const Kind& kind : Kinds()) {
    std::mt19937_64 random(6);
    RigidState elsewhere{kFirst, {}};
    Advance(kind.constraint, elsewhere, {2.0 * RandomDirection(random), RandomDirection(random)},
            0.2, 0, kNoLimit);
    RigidState state{kFirst, {}};
    for (int frame = 0; frame < 4000; ++frame) {
      ASSERT_LE(Follow(kind.constraint, state, elsewhere.X_WB, kStep, 0.02, 2.5e-4), 2.5e-4);
      ASSERT_LT(kind.fault(state.X_WB), 1e-9) << kind.name;
    }
    EXPECT_LT((state.X_WB.p - elsewhere.X_WB.p).norm(), 1e-9) << kind.name;
    EXPECT_LT(RotationVector(state.X_WB.q * elsewhere.X_WB.q.conjugate()).norm(), 1e-9)
        << kind.name;
  }
}

TEST(Constraint, NearestPoseIsAProjection) {
  std::mt19937_64 random(7);
  for (const Kind& kind : Kinds()) {
    for (int trial = 0; trial < 50; ++trial) {
      const Pose any{RandomRotation(random), RandomDirection(random)};
      const Pose nearest = kind.constraint.Nearest(any);
      EXPECT_LT(kind.fault(nearest), 1e-12) << kind.name;
      EXPECT_LT((kind.constraint.Nearest(nearest).p - nearest.p).norm(), 1e-12) << kind.name;
    }
  }
}

// Nothing pulls: a body that spins about a hinge away from its centre of mass, or tumbles on a
// ball, never gains energy; on the hinge, whose motion is plain, it loses none either.
TEST(Constraint, NeverAddsEnergy) {
  for (const Kind& kind : Kinds()) {
    std::mt19937_64 random(8);
    RigidState state{kFirst, {}};
    LinearizedForce push;
    push.force << 40.0 * RandomDirection(random), 60.0 * RandomDirection(random);
    Advance(kind.constraint, state,
            ConstrainedTwist(kind.constraint, HalfBrick(), state, push, kStep), kStep, 0.1,
            kNoLimit);
    const double first = KineticEnergy(HalfBrick(), state);
    double energy = first;
    for (int frame = 0; frame < 5000; ++frame) {
      const Twist V = ConstrainedTwist(kind.constraint, HalfBrick(), state, {}, kStep);
      Advance(kind.constraint, state, V, kStep, 0.1, kNoLimit);
      const double now = KineticEnergy(HalfBrick(), state);
      ASSERT_LE(now, energy * (1 + 1e-12)) << kind.name << " in frame " << frame;
      energy = now;
    }
    if (std::string(kind.name) == "hinge") {
      EXPECT_NEAR(energy, first, 1e-9 * first);
    }
  }
}

// theta'' = -m g l sin(theta) / (I + m l^2), by Runge and Kutta's method.
TEST(HingeConstraint, SwingsAsAPendulumWithFirstOrderError) {
  const Inertia brick = HalfBrick();
  constexpr double kGravity = 9.81;
  constexpr double kLength = 0.1;
  const double about_pivot = brick.I_B(1, 1) + brick.mass * kLength * kLength;
  const auto pull = [&](double angle) {
    return -brick.mass * kGravity * kLength * std::sin(angle) / about_pivot;
  };
  const double angle = RungeKutta(
      Eigen::Vector2d(1.0, 0.0),
      [&](const Eigen::Vector2d& y) {
        return Eigen::Vector2d(y[1], pull(y[0]));
      },
      1e-4, 5000)[0];
  const auto error = [&](double h) {
    const Pose X_WB0{Quat::Identity(), Vec3(0, 0, -kLength)};
    const Constraint hinge = HingeConstraint(X_WB0, Vec3::Zero(), Vec3::UnitY());
    RigidState state{X_WB0, {}};
    state.X_WB.q = RotationBy(Vec3(0, -1.0, 0));  // to +x
    state.X_WB.p = state.X_WB.q * X_WB0.p;
    LinearizedForce weight;
    weight.force[5] = -brick.mass * kGravity;
    for (int i = 0; i < std::lround(0.5 / h); ++i) {
      Advance(hinge, state, ConstrainedTwist(hinge, brick, state, weight, h), h, 0.1, kNoLimit);
    }
    return std::abs(std::atan2(state.X_WB.p.x(), -state.X_WB.p.z()) - angle);
  };
  const double coarse = error(1e-3);
  EXPECT_LT(coarse, 0.02);
  EXPECT_NEAR(coarse / error(5e-4), 2.0, 0.2);
}

// A top about a point, in its own axes: I w' = tau - w x I w, by Runge and Kutta's method.
TEST(BallConstraint, MovesAsASpinningTopWithFirstOrderError) {
  const Inertia brick = HalfBrick();
  const Vec3 lever(0.05, -0.02, 0.03);  // to the centre of mass, in B
  const Mat3 about_point = brick.I_B - brick.mass * CrossMatrix(lever) * CrossMatrix(lever);
  const Vec3 weight_W(0, 0, -9.81 * brick.mass);
  using Motion = Eigen::Matrix<double, 7, 1>;  // q, then w in B
  const auto rate = [&](const Motion& y) {
    const Quat q(y[3], y[0], y[1], y[2]);
    const Vec3 w_B = y.tail<3>();
    const Vec3 tau = lever.cross(q.conjugate() * weight_W);
    Motion dy;
    dy << QuatRate(q, q * w_B), about_point.inverse() * (tau - w_B.cross(about_point * w_B));
    return dy;
  };
  Motion start;
  start << 0, 0, 0, 1, 2, -6, 4;
  const Motion exact = RungeKutta(start, rate, 1e-4, 3000);
  const Quat q = Quat(exact[3], exact[0], exact[1], exact[2]).normalized();
  const auto error = [&](double h) {
    const Pose X_WB0{Quat::Identity(), lever};
    const Constraint ball = BallConstraint(X_WB0, Vec3::Zero());
    RigidState state{X_WB0, {Vec3(2, -6, 4), Vec3(2, -6, 4).cross(lever)}};
    LinearizedForce weight;
    weight.force.tail<3>() = weight_W;
    for (int i = 0; i < std::lround(0.3 / h); ++i) {
      Advance(ball, state, ConstrainedTwist(ball, brick, state, weight, h), h, 0.1, kNoLimit);
    }
    return RotationVector(state.X_WB.q * q.conjugate()).norm();
  };
  const double coarse = error(1e-3);
  EXPECT_LT(coarse, 0.05);
  EXPECT_NEAR(coarse / error(5e-4), 2.0, 0.25);
}

}  // namespace
}  // namespace tandem
