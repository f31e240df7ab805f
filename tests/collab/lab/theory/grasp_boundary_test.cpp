#include "collab/lab/theory/grasp_boundary.h"

#include <cmath>
#include <deque>
#include <vector>

#include <gtest/gtest.h>

#include "collab/lab/theory/exact_boundary.h"

namespace tandem {
namespace {

const Inertia kLightCube{0.3, 0.3 * 6e-4 * Mat3::Identity()};

/// Returns a hand whose turning goes as its travel does.
HandImpedance Hand(double mass, double damping, double stiffness) {
  const double per_mass = 6e-4;  // m^2
  return {mass, damping, stiffness, per_mass * mass, per_mass * damping, per_mass * stiffness};
}

GraspCoupling Alike(std::size_t users, const HandImpedance& hand, const Vec3& grasp_B,
                    double ground, double delay_s) {
  GraspCoupling coupling;
  coupling.users.assign(users, Grasp(kLightCube, hand, grasp_B, ground));
  coupling.delay_s = delay_s;
  return coupling;
}

// Held at its centre, all six axes are those of the equation of one.
TEST(GraspBoundary, ReducesToOneAxisForCentralGrasps) {
  for (const double delay_s : {0.03, 0.3, 1.0}) {
    for (const std::size_t users : {2U, 4U}) {
      GraspCoupling coupling = Alike(users, Hand(1.2, 2.3, 0), Vec3::Zero(), 10, delay_s);
      coupling.relative_damping = 5;
      LumpedCoupling lumped{
          .mass = 1.5, .damping = 12.3, .relative_damping = 5, .delay_s = delay_s, .users = users};
      const double exact = CriticalStiffness(lumped);
      const double found = CriticalStiffness(coupling, 10 / delay_s, 1e6);
      if (std::isfinite(exact)) {
        EXPECT_NEAR(found, exact, 0.011 * exact) << delay_s << " s, " << users << " users";
      }
      lumped.stiffness = coupling.stiffness = 0.5 * std::min(exact, 1e4);
      const double decay = -RightmostRoot(lumped).real();
      if (decay < 0.9) {
        EXPECT_NEAR(*SlowestDecay(coupling), decay, 0.06 * decay);
      }
    }
  }
}

/// Integrates two users in time, by steps of a fifth of a millisecond that know of no
/// characteristic equation. Returns how much their velocity grows from the second quarter to the
/// last, as a logarithm.
double GrowthInTime(const GraspCoupling& coupling, double seconds) {
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  constexpr double kStep = 2e-4;  // s
  const auto late = static_cast<std::size_t>(std::lround(coupling.delay_s / kStep));
  std::vector<Vec6> x(2, Vec6::Zero());
  std::vector<Vec6> v(2, Vec6::Zero());
  v[0] << 0.1, -0.05, 0.02, 0.07, 0.03, -0.06;
  std::vector<std::deque<std::pair<Vec6, Vec6>>> past(
      2, std::deque<std::pair<Vec6, Vec6>>(late + 1, {Vec6::Zero(), Vec6::Zero()}));
  const auto steps = static_cast<int>(seconds / kStep);
  double early = 0;
  double last = 0;
  std::vector<Mat6> inverse;
  for (const GraspedBody& user : coupling.users) inverse.emplace_back(user.mass.inverse());
  for (int step = 0; step < steps; ++step) {
    for (std::size_t i = 0; i < 2; ++i) {
      past[i].emplace_back(x[i], v[i]);
      past[i].pop_front();
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& [y, u] = past[1 - i].front();
      const GraspedBody& user = coupling.users[i];
      const Vec6 force = coupling.stiffness * (y - x[i]) + coupling.relative_damping * (u - v[i]) -
                         user.damping * v[i] - user.stiffness * x[i];
      v[i] += kStep * (inverse[i] * force);
    }
    for (std::size_t i = 0; i < 2; ++i) x[i] += kStep * v[i];
    const double square = v[0].squaredNorm() + v[1].squaredNorm();
    if (step > steps / 4 && step <= steps / 2) early += square;
    if (step > 3 * (steps / 4)) last += square;
  }
  return 0.5 * std::log(last / early);
}

TEST(GraspBoundary, MatchesTimeDomainGrowthForUnequalGraspsAndHands) {
  GraspCoupling coupling;
  coupling.users = {Grasp(kLightCube, Hand(1.2, 1.0, 0), Vec3(0.05, 0.02, 0), 4),
                    Grasp(kLightCube, Hand(0.4, 3.0, 20), Vec3(0, -0.03, 0.06), 4)};
  coupling.delay_s = 0.15;
  coupling.relative_damping = 2;
  const double critical = CriticalStiffness(coupling, 4 / coupling.delay_s, 1e5);
  ASSERT_TRUE(std::isfinite(critical));
  coupling.stiffness = 0.9 * critical;
  EXPECT_LT(GrowthInTime(coupling, 80), 0);
  coupling.stiffness = 1.1 * critical;
  EXPECT_GT(GrowthInTime(coupling, 80), 0);
}

// A mass beside the centre is a large mass to turning: the boundary falls, though travel's stays.
TEST(GraspBoundary, FallsWithTheDistanceOfTheGrasp) {
  double last = 1e9;
  for (const double distance : {0.0, 0.02, 0.05}) {
    const GraspCoupling coupling = Alike(2, Hand(1.2, 0.3, 0), Vec3(distance, 0, 0), 10, 0.3);
    const double critical = CriticalStiffness(coupling, 10 / 0.3, 1e5);
    EXPECT_LT(critical, last) << distance;
    last = critical;
  }
}

TEST(GraspBoundary, CountsOneRootPerFreeDirection) {
  GraspCoupling coupling = Alike(2, Hand(0.5, 1, 0), Vec3(0.05, 0, 0), 5, 0.05);
  coupling.stiffness = 50;
  EXPECT_EQ(RootsRightOf(coupling, 1e-6), 0);
  EXPECT_EQ(RootsRightOf(coupling, -1e-3), 6);
}

}  // namespace
}  // namespace tandem
