#include "collab/lab/theory/exact_boundary.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

// Figures marked "recorded" are what an independent program in Python (brentq, a count of crossings
// by half turns, Newton from a grid, in scipy) printed.

struct ClosedRow {
  double mass, damping, delay_s, critical, safe, onset_hz;
};
// recorded: k_crit(tau, b, m), k_safe(tau, b, m), w_crit(tau, b, m) / 2 pi
constexpr ClosedRow kClosed[] = {
    {1.5, 5, 0.01, 505.6, 505.6, 4.10},  {1.5, 5, 0.03, 172.3, 172.2, 2.35},
    {1.5, 5, 0.1, 55.7, 55.6, 1.26},     {1.5, 5, 0.3, 22.6, 22.2, 0.69},
    {1.5, 5, 1.0, 11.5, 10.6, 0.33},     {1.5, 10, 0.01, 1022.3, 1022.2, 5.78},
    {1.5, 10, 0.03, 355.8, 355.6, 3.30}, {1.5, 10, 0.1, 123.1, 122.2, 1.74},
    {1.5, 10, 0.3, 58.0, 55.6, 0.91},    {1.5, 10, 1.0, 37.8, 32.2, 0.39},
    {0.5, 5, 0.01, 516.8, 516.7, 7.06},  {0.5, 5, 0.03, 183.7, 183.3, 4.01},
    {0.5, 5, 0.1, 67.7, 66.7, 2.08},     {0.5, 5, 0.3, 35.9, 33.3, 1.05},
    {0.5, 5, 1.0, 26.7, 21.7, 0.42},     {0.5, 10, 0.01, 1067.5, 1066.7, 9.90},
    {0.5, 10, 0.03, 402.5, 400.0, 5.54}, {0.5, 10, 0.1, 174.0, 166.7, 2.74},
    {0.5, 10, 0.3, 115.8, 100.0, 1.27},  {0.5, 10, 1.0, 102.0, 76.7, 0.45},
};

TEST(ExactBoundary, MatchesTheRecordedTable) {
  for (const ClosedRow& row : kClosed) {
    SCOPED_TRACE(std::to_string(row.mass) + " kg, b " + std::to_string(row.damping) + ", tau " +
                 std::to_string(row.delay_s));
    const double critical = CriticalStiffness(row.delay_s, row.damping, row.mass);
    EXPECT_NEAR(critical, row.critical, 0.005 * row.critical);
    EXPECT_NEAR(SafeStiffness(row.delay_s, row.damping, row.mass), row.safe, 0.005 * row.safe);
    EXPECT_NEAR(OnsetFrequency(row.delay_s, row.damping, row.mass) / (2 * M_PI), row.onset_hz,
                0.006);
    EXPECT_NEAR(CriticalDelay(critical, row.damping, row.mass), row.delay_s, 1e-6 * row.delay_s);
    EXPECT_LE(PassiveStiffness(row.delay_s, row.damping), critical);
    EXPECT_LE(AnyDelayStiffness(row.damping, row.mass), critical);
  }
  EXPECT_NEAR(CriticalDelay(60, 10, 1.5), 0.28210, 1e-5);  // recorded: tau_crit(k, b, m)
  EXPECT_NEAR(CriticalDelay(200, 5, 0.5), 0.0273168, 1e-6);
  EXPECT_TRUE(std::isinf(CriticalDelay(33, 10, 1.5)));
}

TEST(ExactBoundary, TheSafeStiffnessIsNeverAboveIt) {
  for (double damping = 0.1; damping < 100; damping *= 1.3) {
    for (double delay = 1e-3; delay < 3; delay *= 1.3) {
      for (const double mass : {0.1, 1.0, 5.0}) {
        EXPECT_LE(SafeStiffness(delay, damping, mass),
                  CriticalStiffness(delay, damping, mass) * (1 + 1e-9));
      }
    }
  }
}

// The count of crossings knows nothing of the closed form.
TEST(ExactBoundary, CrossingCountMatchesTheClosedForm) {
  for (const ClosedRow& row : kClosed) {
    const double counted =
        CriticalStiffness({.mass = row.mass, .damping = row.damping, .delay_s = row.delay_s});
    const double closed = CriticalStiffness(row.delay_s, row.damping, row.mass);
    EXPECT_NEAR(counted, closed, 1e-6 * closed);
  }
}

struct VerdictRow {
  LumpedCoupling model;
  bool stable;
};
// recorded: stable_exact(k, b, m, kh, bc, tau, N = 2)
const VerdictRow kVerdicts[] = {
    {{1.5, 10, 0, 120, 0, 0.1}, true},    {{1.5, 10, 0, 80, 0, 0.1}, true},
    {{1.5, 10, 300, 120, 0, 0.1}, true},  {{1.5, 10, 300, 300, 0, 0.1}, false},
    {{1.5, 10, 0, 200, 10, 0.3}, false},  {{1.5, 10, 0, 60, 10, 0.3}, true},
    {{1.5, 10, 0, 95, 10, 1.0}, true},    {{1.5, 10, 0, 120, 10, 1.0}, false},
    {{1.5, 20, 800, 300, 0, 0.05}, true}, {{0.5, 5, 800, 500, 0, 0.05}, false},
};

TEST(ExactBoundary, JudgesAsRecordedWithHandsAndRelativeDamping) {
  for (const VerdictRow& row : kVerdicts) {
    EXPECT_EQ(IsStable(row.model), row.stable)
        << "K " << row.model.stiffness << ", kh " << row.model.hand_stiffness << ", Bc "
        << row.model.relative_damping << ", tau " << row.model.delay_s;
  }
}

struct RootRow {
  LumpedCoupling model;
  double growth, w;
};
// recorded: roots_rightmost(m, b, kh, K, r, lambda = -1, tau)
const RootRow kRoots[] = {
    {{1.5, 5, 0, 100, 0, 0.1}, 0.887665, 10.133423},
    {{0.5, 10, 0, 80, 4, 0.3}, -0.901390, 7.715298},
    {{1.5, 10, 300, 200, 0, 0.1}, 0.278395, 17.623321},
    {{1.5, 12, 0, 40, 4, 1.0}, -0.159105, 2.456307},
};

TEST(ExactBoundary, TheRightmostRootIsTheRecordedOne) {
  for (const RootRow& row : kRoots) {
    const std::complex<double> root = RightmostRoot(row.model);
    EXPECT_NEAR(root.real(), row.growth, 1e-5);
    EXPECT_NEAR(root.imag(), row.w, 1e-5);
  }
}

// Two ways to one answer: where the count says stable, no root is to the right. This holds for all
// users, with hands and relative damping.
TEST(ExactBoundary, TheCountAndTheRootsAgree) {
  int right = 0;
  int left = 0;
  for (const std::size_t users : {2U, 3U, 4U, 8U}) {
    for (const double hand : {0.0, 300.0}) {
      for (const double relative : {0.0, 8.0}) {
        for (const double delay : {0.05, 0.3}) {
          const LumpedCoupling at{.mass = 1.2,
                                  .damping = 6,
                                  .hand_stiffness = hand,
                                  .relative_damping = relative,
                                  .delay_s = delay,
                                  .users = users};
          const double critical = CriticalStiffness(at, 2000);
          for (const double ratio : {0.9, 1.1}) {
            LumpedCoupling model = at;
            model.stiffness = ratio * std::min(critical, 1000.0);
            const double growth = RightmostRoot(model).real();
            EXPECT_EQ(IsStable(model), growth < 0)
                << users << " users, hand " << hand << ", Bc " << relative << ", tau " << delay;
            (growth < 0 ? left : right) += 1;
          }
        }
      }
    }
  }
  EXPECT_GT(left, 20);
  EXPECT_GT(right, 5);
}

// recorded: growth at those multiples of k_crit, 1/s
TEST(ExactBoundary, GrowthBesideTheBoundaryIsAsRecorded) {
  struct Row {
    double mass, damping, delay_s, ratio, growth;
  };
  const Row rows[] = {{1.5, 5, 0.1, 0.8, -0.27},  {1.5, 5, 0.1, 1.1, 0.13},
                      {1.5, 5, 0.1, 2, 1.08},     {1.5, 5, 1.0, 1.1, 0.03},
                      {0.5, 10, 0.3, 0.9, -0.07}, {0.5, 10, 0.3, 1.5, 0.19},
                      {0.5, 10, 0.03, 2, 5.00}};
  for (const Row& row : rows) {
    const LumpedCoupling model{
        .mass = row.mass,
        .damping = row.damping,
        .stiffness = row.ratio * CriticalStiffness(row.delay_s, row.damping, row.mass),
        .delay_s = row.delay_s};
    EXPECT_NEAR(RightmostRoot(model).real(), row.growth, 0.0055);
  }
}

TEST(ExactBoundary, PassiveInjectionIsAsRecorded) {
  const double rows[][2] = {{0, 1}, {.25, .5}, {.5, .164}, {.75, .091}, {1, .063}, {2, .028}};
  for (const auto& [ratio, injection] : rows) {
    EXPECT_NEAR(PassiveInjection(ratio), injection, 0.0006);
  }
}

// recorded: linear_k0max(b, m, kh, bc), the first of steps of 4.7 % that fails
TEST(ExactBoundary, TheLinearLawIsAsSoftAsRecorded) {
  struct Row {
    double damping, mass, hand, relative, k0;
  };
  const Row rows[] = {{2, 1.5, 0, 0, 10.1},     {5, 1.5, 0, 0, 32.2},     {10, 1.5, 0, 0, 85.0},
                      {20, 1.5, 0, 0, 246.6},   {2, 1.5, 0, 10, 67.5},    {5, 1.5, 0, 10, 117.6},
                      {10, 1.5, 0, 10, 214.6},  {20, 1.5, 0, 10, 471.4},  {2, 1.5, 300, 0, 33.7},
                      {5, 1.5, 300, 0, 89.1},   {10, 1.5, 300, 0, 195.6}, {20, 1.5, 300, 0, 471.4},
                      {10, 1.5, 800, 0, 296.7}, {2, 0.5, 0, 0, 13.4},     {10, 0.5, 0, 0, 162.6}};
  for (const Row& row : rows) {
    const double k0 = LargestLinearStiffness(row.damping, row.mass, row.hand, row.relative);
    EXPECT_LE(k0, 1.005 * row.k0) << row.damping << " " << row.hand << " " << row.relative;
    EXPECT_GE(k0, row.k0 / 1.055) << row.damping << " " << row.hand << " " << row.relative;
  }
}

// No number stands there for a stiffness that every delay leaves stable.
TEST(ExactBoundary, TerminatesOnOverflow) {
  LumpedCoupling model;
  model.delay_s = 0.1;
  model.mass = 1e308;
  model.damping = 1e308;
  model.hand_stiffness = 1e308;
  EXPECT_EQ(CriticalStiffness(model, 1e5), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace tandem
