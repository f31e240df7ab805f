// Tests the motion of bodies that nothing but gravity pulls against the textbook: torque-free
// bodies, tops and pendulums.
#include "engine/dynamics/free_motion.h"

#include <cmath>
#include <numbers>

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

constexpr double kStep = 1e-3;     // s
constexpr double kNoLimit = 1e9;   // m
constexpr double kGravity = 9.81;  // m/s^2
const AxisRadii kSmall = AxisRadii::Ball(0.01);

Inertia Brick() {
  return {0.3, Vec3(2e-4, 5e-4, 6e-4).asDiagonal()};
}

Vec3 Momentum(const Inertia& inertia, const RigidState& state) {
  return state.X_WB.q * (inertia.I_B * (state.X_WB.q.conjugate() * state.V_WB.w));
}

double Kinetic(const Inertia& inertia, const RigidState& state) {
  return 0.5 * state.V_WB.w.dot(Momentum(inertia, state)) +
         0.5 * inertia.mass * state.V_WB.v.squaredNorm();
}

TEST(FreeMotion, KeepsTheEnergyAndMomentumOfATorqueFreeBody) {
  std::mt19937_64 random(3);
  for (const double speed : {0.3, 3.0, 30.0, 300.0}) {
    RigidState state{{RandomRotation(random), Vec3::Zero()}, {}};
    // close to the middle axis, about which a brick tumbles
    state.V_WB.w = speed * (state.X_WB.q * Vec3(0.05, 0.99, 0.02).normalized());
    const Vec3 momentum = Momentum(Brick(), state);
    const double energy = Kinetic(Brick(), state);
    for (int i = 0; i < 2000; ++i) {
      AdvanceFreely(Brick(), std::nullopt, state, state.V_WB, kStep, kSmall, kNoLimit);
    }
    EXPECT_LT((Momentum(Brick(), state) - momentum).norm(), 1e-9 * momentum.norm()) << speed;
    EXPECT_NEAR(Kinetic(Brick(), state), energy, 1e-9 * energy) << speed;
  }
}

TEST(FreeMotion, NeverGainsEnergyHoweverFastTheBodyTurns) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 100; ++trial) {
    RigidState state{{RandomRotation(random), Vec3::Zero()}, {}};
    state.V_WB.w = Uniform(random, 300, 20000) * RandomDirection(random);
    const double energy = Kinetic(Brick(), state);
    for (int i = 0; i < 100; ++i) {
      AdvanceFreely(Brick(), std::nullopt, state, state.V_WB, kStep, kSmall, kNoLimit);
      ASSERT_LE(Kinetic(Brick(), state), energy * (1 + 1e-9)) << trial;
    }
  }
}

TEST(FreeMotion, ATumblingBrickTurnsAsEulersEquationsSay) {
  const Inertia inertia = Brick();
  const Vec3 w_B(0.2, 8.0, 0.1);
  using Seven = Eigen::Matrix<double, 7, 1>;
  Seven start;
  start << w_B, Quat::Identity().coeffs();
  const auto rate = [&](const Seven& y) {
    const Vec3 w = y.head<3>();
    const Quat q(Eigen::Vector4d(y.tail<4>()));
    Seven change;
    change << inertia.I_B.inverse() * -w.cross(inertia.I_B * w), QuatRate(q, q * w);
    return change;
  };
  const Seven exact = RungeKutta(start, rate, 1e-4, 10'000);
  const auto error = [&](double h) {
    RigidState state;
    state.V_WB.w = w_B;
    const auto steps = std::lround(1.0 / h);
    for (long i = 0; i < steps; ++i) {
      AdvanceFreely(inertia, std::nullopt, state, state.V_WB, h, kSmall, kNoLimit);
    }
    const Quat there(Eigen::Vector4d(exact.tail<4>().normalized()));
    return RotationVector(state.X_WB.q * there.conjugate()).norm();
  };
  const double coarse = error(1e-3);
  EXPECT_LT(coarse, 0.005);
  // the step is of second order
  EXPECT_NEAR(coarse / error(5e-4), 4.0, 0.4);
}

// Euler's free top: its axis goes round the moment of momentum at |L| / I1.
TEST(FreeMotion, AFreeTopGoesRoundItsMomentAsTheClosedFormSays) {
  const Inertia top{0.1, Vec3(3e-5, 3e-5, 5e-5).asDiagonal()};
  RigidState state;
  state.V_WB.w = Vec3(4, 0, 20);
  const Vec3 momentum = Momentum(top, state);
  const Vec3 along = momentum.normalized();
  const auto angle = [&] {
    const Vec3 axis = state.X_WB.q * Vec3::UnitZ();
    const Vec3 u = (Vec3::UnitZ() - along.z() * along).normalized();
    return std::atan2(axis.dot(along.cross(u)), axis.dot(u));
  };
  const double exact = momentum.norm() / 3e-5;
  double turned = 0;
  double before = angle();
  for (int i = 0; i < 1000; ++i) {
    AdvanceFreely(top, std::nullopt, state, state.V_WB, kStep, kSmall, kNoLimit);
    const double now = angle();
    turned += std::remainder(now - before, 2 * std::numbers::pi);
    before = now;
  }
  EXPECT_NEAR(turned, exact, 0.001 * exact);
}

TEST(FreeMotion, FreeFallIsExact) {
  RigidState state{{}, {Vec3::Zero(), Vec3(1, 0, 2)}};
  for (int i = 0; i < 1000; ++i) {
    Fly(Brick(), std::nullopt, state, Vec3(0, 0, -kGravity), kStep, kSmall, kNoLimit);
  }
  EXPECT_NEAR(state.X_WB.p.x(), 1.0, 1e-12);
  EXPECT_NEAR(state.X_WB.p.z(), 2 - 0.5 * kGravity, 1e-12);
  EXPECT_NEAR(state.V_WB.v.z(), 2 - kGravity, 1e-12);
}

/// Returns the speeds at which a heavy top of tilt `angle` and spin `w3` goes round steadily:
/// roots of I1 cos(angle) W^2 - I3 w3 W + m g l = 0 (I1 about the tip).
double SlowPrecession(double I1, double I3, double w3, double moment, double angle) {
  const double a = I1 * std::cos(angle);
  return (I3 * w3 - std::sqrt(I3 * I3 * w3 * w3 - 4 * a * moment)) / (2 * a);
}

TEST(FreeMotion, ASpinningTopPrecessesAsTheClosedFormSays) {
  const Inertia top{0.1, Vec3(3e-5, 3e-5, 5e-5).asDiagonal()};
  constexpr double kHeight = 0.03;
  const double I1 = 3e-5 + 0.1 * kHeight * kHeight;
  for (const double tilt : {0.2, 0.6, 1.0}) {
    for (const double spin : {150.0, 300.0}) {
      const double round = SlowPrecession(I1, 5e-5, spin, 0.1 * kGravity * kHeight, tilt);
      RigidState state;
      state.X_WB.q = RotationBy(Vec3(tilt, 0, 0));
      const Vec3 axis = state.X_WB.q * Vec3::UnitZ();
      state.X_WB.p = kHeight * axis;
      const Constraint tip = BallConstraint(state.X_WB, Vec3::Zero());
      state.V_WB.w = round * (Vec3::UnitZ() - std::cos(tilt) * axis) + spin * axis;
      state.V_WB.v = state.V_WB.w.cross(state.X_WB.p);
      const auto energy = [&] {
        return Kinetic(top, state) + 0.1 * kGravity * state.X_WB.p.z();
      };
      const double first = energy();
      double turned = 0;
      double before = std::atan2(state.X_WB.p.y(), state.X_WB.p.x());
      double least = kHeight;
      double most = -kHeight;
      double off = 0;
      for (int i = 0; i < 2000; ++i) {
        Fly(top, tip, state, Vec3(0, 0, -kGravity), kStep, kSmall, kNoLimit);
        const double now = std::atan2(state.X_WB.p.y(), state.X_WB.p.x());
        turned += std::remainder(now - before, 2 * std::numbers::pi);
        before = now;
        least = std::min(least, state.X_WB.p.z());
        most = std::max(most, state.X_WB.p.z());
        off = std::max(off, energy() - first);
      }
      EXPECT_NEAR(turned, 2 * round, 0.03 * 2 * round) << tilt << ", " << spin;
      // steady: the axis keeps its tilt
      EXPECT_LT(most - least, 0.02 * kHeight) << tilt << ", " << spin;
      EXPECT_LT(off, 1e-3 * 0.1 * kGravity * kHeight) << tilt << ", " << spin;
    }
  }
}

double ArithmeticGeometricMean(double a, double b) {
  for (int i = 0; i < 20; ++i) {
    const double next = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = next;
  }
  return a;
}

// A pendulum of any swing: T = 2 pi sqrt(I / (m g l)) / agm(1, cos(angle / 2)).
TEST(FreeMotion, APendulumSwingsAsTheClosedFormSays) {
  const Inertia bob{0.3, Vec3(2e-4, 5e-4, 6e-4).asDiagonal()};
  constexpr double kLength = 0.1;
  for (const double swing : {0.1, 1.0, 2.0, 3.0}) {
    RigidState state;
    const Vec3 axis = Vec3::UnitY();
    const Quat turned = RotationBy(swing * axis);
    state.X_WB = {turned, turned * Vec3(0, 0, -kLength)};
    const Constraint hinge = HingeConstraint(state.X_WB, Vec3::Zero(), axis);
    const double weight = 0.3 * kGravity;
    const double period = 2 * std::numbers::pi *
                          std::sqrt((5e-4 + 0.3 * kLength * kLength) / (weight * kLength)) /
                          ArithmeticGeometricMean(1, std::cos(swing / 2));
    const double exchanged = weight * kLength * (1 - std::cos(swing));
    const double first = weight * state.X_WB.p.z();
    // from one passage of the lowest place to the tenth after it
    double begin = -1;
    double end = -1;
    int passages = 0;
    double off = 0;
    for (int i = 0; end < 0 && i < 20'000; ++i) {
      const double before = state.X_WB.p.x();
      Fly(bob, hinge, state, Vec3(0, 0, -kGravity), kStep, kSmall, kNoLimit);
      off = std::max(off, std::abs(Kinetic(bob, state) + weight * state.X_WB.p.z() - first));
      const double now = state.X_WB.p.x();
      if ((before < 0) == (now < 0)) continue;
      const double at = (i + before / (before - now)) * kStep;
      if (begin < 0) begin = at;
      if (passages++ == 10) end = at;
    }
    EXPECT_NEAR((end - begin) / 5, period, 1e-3 * period) << swing;
    EXPECT_LT(off, 1e-3 * exchanged) << swing;
  }
}

// Brute force: points all over a slender cylinder that spins about an axis near its own.
TEST(FreeMotion, NoPointGoesFartherThanAllowed) {
  constexpr double kRadius = 0.005;
  constexpr double kHalf = 0.05;
  const Inertia slender{0.1, Vec3(8e-5, 8e-5, 1.25e-6).asDiagonal()};
  const double far = std::hypot(kRadius, kHalf);
  const AxisRadii radii{.radii = Vec3(far, far, kRadius), .radius = far};
  std::mt19937_64 random(5);
  bool held = false;
  bool free = false;
  for (int trial = 0; trial < 500; ++trial) {
    RigidState state{{RandomRotation(random), Vec3::Zero()}, {}};
    const Vec3 about = (Vec3::UnitZ() + Uniform(random, 0, 0.3) * RandomDirection(random));
    state.V_WB.w = Uniform(random, 0, 150) * (state.X_WB.q * about);
    state.V_WB.v = Uniform(random, 0, 0.2) * RandomDirection(random);
    const Pose before = state.X_WB;
    constexpr double kLimit = 5e-4;
    const bool limited =
        AdvanceFreely(slender, std::nullopt, state, state.V_WB, kStep, radii, kLimit);
    held = held || limited;
    free = free || !limited;
    for (int i = 0; i < 200; ++i) {
      const double angle = Uniform(random, 0, 2 * std::numbers::pi);
      const Vec3 p_B(kRadius * std::cos(angle), kRadius * std::sin(angle),
                     Uniform(random, -kHalf, kHalf));
      ASSERT_LE((state.X_WB * p_B - before * p_B).norm(), kLimit * (1 + 1e-9)) << trial;
    }
  }
  EXPECT_TRUE(held);
  EXPECT_TRUE(free);
}

}  // namespace
}  // namespace tandem
