#include <gtest/gtest.h>

#include "engine/dynamics/virtual_coupling.h"
#include "tests/engine/dynamics/runge_kutta.h"

namespace tandem {
namespace {

using testing::QuatRate;
using testing::RungeKutta;

// Two bodies in space, a spring and damper between places off their centres of mass, both turning:
// as two users' copies of a part, or two parts in one frame of the loop.
constexpr double kStiffness = 80;  // N/m
constexpr double kDamping = 0.4;   // N s/m
constexpr double kSeconds = 0.25;
const std::array<Inertia, 2> kInertia{
    {{0.3, Vec3(2e-4, 5e-4, 6e-4).asDiagonal()}, {0.5, Vec3(9e-4, 3e-4, 7e-4).asDiagonal()}}};
const std::array<Vec3, 2> kHook{{Vec3(0.03, 0.01, 0), Vec3(-0.02, 0.02, 0.01)}};  // p_BH

std::array<RigidState, 2> Start() {
  std::array<RigidState, 2> bodies;
  bodies[0].X_WB.p = Vec3(-0.05, 0, 0);
  bodies[0].V_WB = {Vec3(1, 3, -2), Vec3(0, 0.1, 0)};
  bodies[1].X_WB.p = Vec3(0.06, 0.01, 0);
  bodies[1].V_WB = {Vec3(-2, 1, 2), Vec3(0, 0, 0.05)};
  return bodies;
}

std::array<RigidState, 2> Stepped(double h) {
  const CouplingGains gains{kStiffness, kDamping, Mat3::Zero(), Mat3::Zero()};
  std::array<RigidState, 2> bodies = Start();
  for (int i = 0; i < std::lround(kSeconds / h); ++i) {
    const std::array<RigidState, 2> before = bodies;
    for (std::size_t b = 0; b < 2; ++b) {
      const RigidState& other = before[1 - b];
      const Vec3 lever = other.X_WB.q * kHook[1 - b];
      const Anchor anchor{{Quat::Identity(), other.X_WB.p + lever},
                          {Vec3::Zero(), other.V_WB.v + other.V_WB.w.cross(lever)}};
      const LinearizedForce load =
          CouplingForce(gains, before[b], {Quat::Identity(), kHook[b]}, anchor);
      Advance(bodies[b], ImplicitTwist(kInertia[b], before[b], load, h), h, 0.1, 1e9);
    }
  }
  return bodies;
}

/// Per body: p (3), q (4), v (3), angular momentum about the centre of mass in W (3).
using Motion = Eigen::Matrix<double, 26, 1>;

Motion RateOf(const Motion& y) {
  std::array<Vec3, 2> hook_W;
  std::array<Vec3, 2> hook_speed;
  std::array<Vec3, 2> lever;
  std::array<Vec3, 2> w;
  Motion rate;
  for (int b = 0; b < 2; ++b) {
    const auto body = static_cast<std::size_t>(b);
    const Eigen::Index at = 13 * b;
    const Quat q(y[at + 6], y[at + 3], y[at + 4], y[at + 5]);
    const Mat3 R = q.normalized().toRotationMatrix();
    w[body] = R * kInertia[body].I_B.inverse() * R.transpose() * y.segment<3>(at + 10);
    lever[body] = R * kHook[body];
    hook_W[body] = y.segment<3>(at) + lever[body];
    hook_speed[body] = y.segment<3>(at + 7) + w[body].cross(lever[body]);
    rate.segment<3>(at) = y.segment<3>(at + 7);
    rate.segment<4>(at + 3) = QuatRate(q, w[body]);
  }
  const Vec3 on_first =
      kStiffness * (hook_W[1] - hook_W[0]) + kDamping * (hook_speed[1] - hook_speed[0]);
  for (int b = 0; b < 2; ++b) {
    const auto body = static_cast<std::size_t>(b);
    const Vec3 force = b == 0 ? on_first : Vec3(-on_first);
    rate.segment<3>(13 * b + 7) = force / kInertia[body].mass;
    rate.segment<3>(13 * b + 10) = lever[body].cross(force);
  }
  return rate;
}

Motion Reference() {
  Motion y;
  const std::array<RigidState, 2> bodies = Start();
  for (int b = 0; b < 2; ++b) {
    const auto body = static_cast<std::size_t>(b);
    const RigidState& state = bodies[body];
    y.segment<13>(13 * b) << state.X_WB.p, state.X_WB.q.coeffs(), state.V_WB.v,
        kInertia[body].I_B * state.V_WB.w;
  }
  constexpr double kFine = 2e-5;
  return RungeKutta(y, RateOf, kFine, static_cast<int>(std::lround(kSeconds / kFine)));
}

TEST(TwoCoupledBodies, HalvingTheStepHalvesPositionAndRotationErrors) {
  const Motion exact = Reference();
  const auto errors = [&](double h) {
    const std::array<RigidState, 2> bodies = Stepped(h);
    Eigen::Array2d of_place_and_turn = Eigen::Array2d::Zero();
    for (int b = 0; b < 2; ++b) {
      const RigidState& state = bodies[static_cast<std::size_t>(b)];
      const Eigen::Index at = 13 * b;
      const Quat q(exact[at + 6], exact[at + 3], exact[at + 4], exact[at + 5]);
      of_place_and_turn[0] += (state.X_WB.p - exact.segment<3>(at)).norm();
      of_place_and_turn[1] += RotationVector(state.X_WB.q * q.normalized().conjugate()).norm();
    }
    return of_place_and_turn;
  };
  const Eigen::Array2d coarse = errors(1e-3);
  const Eigen::Array2d fine = errors(5e-4);
  const Eigen::Array2d finer = errors(2.5e-4);
  EXPECT_LT(coarse[0], 3e-3);
  EXPECT_LT(coarse[1], 0.1);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(coarse[i] / fine[i], 2.0, 0.2);
    EXPECT_NEAR(fine[i] / finer[i], 2.0, 0.1);
  }
}

// Springs and dampers within take energy and give none; nothing outside pulls, so the momentum of
// both together stays.
TEST(TwoCoupledBodies, ConserveMomentum) {
  const auto momentum = [](const std::array<RigidState, 2>& bodies) -> Vec3 {
    return kInertia[0].mass * bodies[0].V_WB.v + kInertia[1].mass * bodies[1].V_WB.v;
  };
  const double coarse = (momentum(Stepped(1e-3)) - momentum(Start())).norm();
  const double fine = (momentum(Stepped(5e-4)) - momentum(Start())).norm();
  // each body's own change of force within a step is foreseen, the other's is not
  EXPECT_NEAR(coarse / fine, 2.0, 0.3);
  EXPECT_LT(coarse, 0.01);  // kg m/s
}

// A body that nothing pulls never gains energy, however fast it tumbles.
TEST(ImplicitTwist, NeverSpeedsUpATumblingBody) {
  for (const double rate : {3.0, 30.0, 300.0, 3000.0}) {
    RigidState state;
    state.V_WB.w = rate * Vec3(0.01, 1.0, 0.02);
    const auto energy_of = [&] {
      const Vec3 w_B = state.X_WB.q.conjugate() * state.V_WB.w;
      return w_B.dot(kInertia[0].I_B * w_B);
    };
    double energy = energy_of();
    for (int i = 0; i < 2000; ++i) {
      Advance(state, ImplicitTwist(kInertia[0], state, {}, 1e-3), 1e-3, 0.1, 1e9);
      const double now = energy_of();
      ASSERT_LE(now, energy * (1 + 1e-12)) << rate;
      energy = now;
    }
  }
}

}  // namespace
}  // namespace tandem
