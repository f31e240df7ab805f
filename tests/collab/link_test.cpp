#include <cmath>

#include <gtest/gtest.h>

#include "collab/delay_meter.h"
#include "collab/stiffness_schedule.h"

namespace tandem {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(DelayMeter, HoldsThePeakForTwoSeconds) {
  DelayMeter meter;
  std::int64_t now = 1000 * kMs;
  const auto run = [&](double seconds, std::int64_t age_ms) {
    for (int i = 0; i < static_cast<int>(1000 * seconds); ++i, now += kMs) {
      meter.Add(now, age_ms * kMs);
    }
  };
  run(0.5, 40);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.040);
  run(0.001, 300);
  run(1.8, 40);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.300);
  run(0.4, 40);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.040);
}

TEST(DelayMeter, ForgetsWhatWasBeforeASilence) {
  DelayMeter meter;
  meter.Add(1000 * kMs, 700 * kMs);
  meter.Add(9000 * kMs, 50 * kMs);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.050);
}

// The table of the default law, sigma 0.8, B 10, K0 500, m_max 1.5: k at te.
TEST(StiffnessSchedule, GivesTheStiffnessOfItsTable) {
  const CouplingLimits limits;
  const auto k = [&](double te) {
    const double peak = (2.0 * te - 0.005) / 1.1;
    return LinkStiffness(CouplingLaw::kPlusDamping, limits, peak, 2, 1.5);
  };
  EXPECT_NEAR(k(0.003), 400, 0.5);
  EXPECT_NEAR(k(0.020), 400, 20);
  EXPECT_NEAR(k(0.050), 178, 1);
  EXPECT_NEAR(k(0.100), 98, 1);
  EXPECT_NEAR(k(0.200), 58, 1);
  EXPECT_NEAR(k(0.300), 44, 1);
  EXPECT_NEAR(k(0.500), 34, 1);
  EXPECT_NEAR(k(1.000), 26, 1);
}

// k_crit = (b^2 + m^2 w^2) / (2 m), w tan(w tau / 2) = b / m: found by bisection, independent of
// the law's bound.
TEST(StiffnessSchedule, StaysBelowTheExactBoundary) {
  const double b = 10;
  for (const double m : {0.5, 1.0, 1.5}) {
    for (double tau = 0.005; tau < 1.0; tau *= 1.3) {
      double low = 0;
      double high = M_PI / tau * 0.999999;
      for (int i = 0; i < 100; ++i) {
        const double w = 0.5 * (low + high);
        (w * std::tan(0.5 * w * tau) < b / m ? low : high) = w;
      }
      const double boundary = (b * b + m * m * low * low) / (2 * m);
      const double peak = 2 * tau;
      EXPECT_LT(LinkStiffness(CouplingLaw::kPlusDamping, {}, peak, 2, m), boundary)
          << m << " kg, " << tau << " s";
    }
  }
}

TEST(StiffnessSchedule, TheLinearLawFallsLinearlyAndKeepsItsFloor) {
  const CouplingLimits limits;
  const auto k = [&](double tau) {
    return LinkStiffness(CouplingLaw::kLinear, limits, 2 * tau, 2, 1.5);
  };
  EXPECT_NEAR(k(0.0), 40.0, 1e-9);
  EXPECT_NEAR(k(0.25), 30.0, 1e-9);
  EXPECT_NEAR(k(0.5), 20.0, 1e-9);
  EXPECT_NEAR(k(1.0), 0.8, 1e-9);
  EXPECT_EQ(k(1.25), 0.0);  // a loop older than 2.4 s
  EXPECT_EQ(LinkDrag(CouplingLaw::kLinear, limits, 20, 0.5), 10.0);
}

TEST(StiffnessSchedule, SharesTheWholeAmongTheLinks) {
  for (const CouplingLaw law : {CouplingLaw::kPlusDamping, CouplingLaw::kLinear}) {
    const double two = LinkStiffness(law, {}, 0.2, 2, 1.5);
    EXPECT_NEAR(LinkStiffness(law, {}, 0.2, 5, 1.5), two / 4, 1e-12);
    EXPECT_EQ(LinkStiffness(law, {}, 0.2, 1, 1.5), 0.0);
    EXPECT_EQ(LinkStiffness(law, {}, 2.5, 2, 1.5), 0.0);
  }
}

TEST(StiffnessSchedule, KnowsItsLawsByName) {
  EXPECT_EQ(CouplingLawNamed("p+d"), CouplingLaw::kPlusDamping);
  EXPECT_EQ(CouplingLawNamed("linear"), CouplingLaw::kLinear);
  EXPECT_FALSE(CouplingLawNamed("constant"));
}

}  // namespace
}  // namespace tandem
