#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "collab/lab/case/case_file.h"
#include "collab/lab/run/case_run.h"

// Compares how far a hand that moves parts the instances with what no law can beat:
// docs/stability.md, 9.13.
namespace tandem {
namespace {

constexpr double kWay = 0.2;      // m, in a second, minimum jerk
constexpr double kPeak = 5.7735;  // peak acceleration of a unit way in a unit time

/// Returns where the hand means to be t seconds after it begins, m.
double MeantAt(double t) {
  if (t <= 0) return 0;
  if (t >= 1) return kWay;
  return kWay * t * t * t * (10 - 15 * t + 6 * t * t);
}

/// Returns the least divergence of a copy that repeats the hand one delay later, m.
double OfACopyThatRepeats(double delay_s) {
  double most = 0;
  for (double t = 0; t <= 1 + delay_s; t += 1e-3) {
    most = std::max(most, MeantAt(t) - MeantAt(t - delay_s));
  }
  return most;
}

/// Returns the same where the copy goes on as it was told that the hand went, m. The acceleration
/// that it has not heard of yet makes the divergence.
double OfACopyThatForesees(double delay_s) {
  return std::min(kWay, 0.5 * kPeak * kWay * delay_s * delay_s);
}

TEST(Divergence, DefaultLawIsWithinASmallFactorOfTheLowerBound) {
  struct Case {
    double delay_s;
    double most_m;   // m; never more than was measured
    double repeats;  // limit, in times the least of a copy that repeats
  };
  for (const Case& row : {Case{0.02, 0.014, 2.0}, Case{0.1, 0.053, 1.5}, Case{0.3, 0.109, 1.1},
                          Case{1.0, 0.171, 0.9}}) {
    SCOPED_TRACE(row.delay_s);
    LabCase test = *ParseCase(R"({"motion": "move", "hands": ["relaxed"]})", "case");
    test.delay_s = row.delay_s;
    const LabScene scene = *LoadLabScene(test, std::filesystem::path(TANDEM_SCENES) / "stability");
    const CaseResult run = RunCase(test, scene);
    ASSERT_FALSE(run.fault);
    EXPECT_EQ(run.verdict, Verdict::kStable);
    EXPECT_LE(run.metrics.peak_apart, row.most_m);
    EXPECT_LT(run.metrics.peak_apart, row.repeats * OfACopyThatRepeats(row.delay_s));
    // a law below this would know what it cannot know; at a second the law holds the hand back, so
    // that the hand does not go where it means to be
    if (row.delay_s < 1) {
      EXPECT_GT(run.metrics.peak_apart, OfACopyThatForesees(row.delay_s));
    }
  }
}

}  // namespace
}  // namespace tandem
