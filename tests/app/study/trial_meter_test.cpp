#include "app/study/trial_meter.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

TrialFrame At(double t_s, double x, double force = 0, bool contact = false) {
  TrialFrame frame{t_s, {}, force, contact};
  frame.X_WB.p = Vec3(x, 0, 0);
  return frame;
}

/// Moves a body by 100 mm a second along x for `seconds`, in frames of a millisecond.
void MoveFor(TrialMeter& meter, double seconds) {
  for (int i = 0; i <= static_cast<int>(std::lround(1e3 * seconds)); ++i) {
    meter.See(At(1e-3 * i, 1e-4 * i));
  }
}

bool IsBeyond150mm(const Pose& X_WB) {
  return X_WB.p.x() > 0.15;
}

// At 100 mm/s a body has gone 100 mm after a second. Looks are 10 ms apart.
TEST(TrialMeter, CompletesAtTheRequiredDistance) {
  TrialMeter meter({.moved_mm = 100, .time_s = 1.05}, {}, nullptr);
  MoveFor(meter, 2);
  const TrialMeasures measures = meter.Finish();
  EXPECT_NEAR(measures.completion_s, 1.0, 0.0101);
  EXPECT_EQ(measures.success, 1);
  EXPECT_NEAR(measures.duration_s, 2, 1e-9);
  EXPECT_NEAR(measures.path_mm, 200, 0.11);
  EXPECT_NEAR(measures.moved_mm, 200, 1e-9);
}

TEST(TrialMeter, FailsBeyondTheTimeLimit) {
  TrialMeter meter({.moved_mm = 100, .time_s = 0.9}, {}, nullptr);
  MoveFor(meter, 2);
  EXPECT_EQ(meter.Finish().success, 0);
}

TEST(TrialMeter, ReturningBodyIsNotOut) {
  TrialMeter meter({.out = true}, {}, IsBeyond150mm);
  MoveFor(meter, 2);
  meter.See(At(2.02, 0.1));
  TrialMeasures measures = meter.Finish();
  EXPECT_TRUE(std::isnan(measures.completion_s));
  EXPECT_EQ(measures.success, 0);
  meter.See(At(2.04, 0.2));
  measures = meter.Finish();
  EXPECT_NEAR(measures.completion_s, 2.04, 1e-9);
  EXPECT_EQ(measures.success, 1);
}

// At 100 mm/s the goal of 100 mm is reached at 1 s, and kept half a second at 1.5 s. The collision
// after that belongs to no trial.
TEST(TrialMeter, EndsAfterTheGoalsHoldTime) {
  TrialMeter meter({.moved_mm = 100, .hold_s = 0.5}, {}, nullptr);
  MoveFor(meter, 1.4);
  EXPECT_FALSE(meter.ended());
  for (int i = 1401; i <= 1600; ++i) meter.See(At(1e-3 * i, 1e-4 * i));
  EXPECT_TRUE(meter.ended());
  meter.See(At(1.7, 0, 50, true));
  const TrialMeasures measures = meter.Finish();
  EXPECT_NEAR(measures.duration_s, 1.5, 0.0201);
  EXPECT_NEAR(measures.completion_s, 1.0, 0.0101);
  EXPECT_EQ(measures.collisions, 0);
  EXPECT_EQ(measures.peak_force_N, 0);
}

TEST(TrialMeter, InterruptionRestartsTheHoldTime) {
  TrialMeter meter({.moved_mm = 100, .hold_s = 0.5}, {}, nullptr);
  MoveFor(meter, 1.4);
  meter.See(At(1.42, 0.05));
  for (int i = 1440; i <= 1900; i += 10) meter.See(At(1e-3 * i, 0.11));
  EXPECT_FALSE(meter.ended());
  meter.See(At(1.95, 0.11));
  EXPECT_TRUE(meter.ended());
  EXPECT_NEAR(meter.Finish().completion_s, 1.44, 1e-9);
}

// Contact at 0.1, at 0.15 after 0.03 s without, at 0.4 after 0.2 s without: two collisions.
TEST(TrialMeter, FlutteringContactIsOneCollision) {
  TrialMeter meter({.collisions = 1}, {}, nullptr);
  for (int i = 0; i < 600; ++i) {
    const bool contact = (i >= 100 && i < 120) || (i >= 150 && i < 200) || (i >= 400 && i < 410);
    meter.See(At(1e-3 * i, 0, contact ? 5 : 1, contact));
  }
  const TrialMeasures measures = meter.Finish();
  EXPECT_EQ(measures.collisions, 2);
  EXPECT_EQ(measures.success, 0);
  EXPECT_NEAR(measures.contact_s, 0.08, 1e-9);
  EXPECT_EQ(measures.peak_force_N, 5);
  EXPECT_NEAR(measures.mean_force_N, (80 * 5 + 520) / 600.0, 1e-9);
}

TEST(TrialMeter, ExcessForcePreventsSuccess) {
  StudySuccess gentle;
  gentle.peak_force_N = 10;
  TrialMeter meter(gentle, {}, nullptr);
  meter.See(At(0, 0, 10));
  EXPECT_EQ(meter.Finish().success, 1);
  meter.See(At(0.001, 0, 10.5));
  EXPECT_EQ(meter.Finish().success, 0);
}

TEST(TrialMeter, DivergenceIsThePeakAndAbsentWithoutAPartner) {
  TrialMeter meter({}, {}, nullptr);
  meter.See(At(0, 0));
  EXPECT_TRUE(std::isnan(meter.Finish().divergence_mm));
  for (const double apart : {0.01, 0.03, 0.02}) meter.SeeApart(apart);
  EXPECT_NEAR(meter.Finish().divergence_mm, 30, 1e-9);
}

}  // namespace
}  // namespace tandem
