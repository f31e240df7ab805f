#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "app/judgement/demo_judgement.h"
#include "tests/support/simulated_demo.h"

namespace tandem {
namespace {

using testing::RunSimulatedDemo;
using testing::SimulatedDemo;
using testing::SimulatedDemoOptions;

SimulatedDemo MustRun(const std::string& scene, const SimulatedDemoOptions& options) {
  Result<SimulatedDemo> demo = RunSimulatedDemo(scene, options);
  EXPECT_TRUE(demo) << (demo ? "" : demo.error().what);
  return demo ? std::move(*demo) : SimulatedDemo{};
}

/// Expects what the demo promises of both instances.
void ExpectWorkedOut(const SimulatedDemo& demo) {
  ASSERT_EQ(demo.traces.size(), 2U);
  for (const std::vector<TraceSample>& trace : demo.traces) {
    ASSERT_FALSE(trace.empty());
    const Outcome outcome = OutcomeOf(*demo.model, 0, trace.back().X_WB);
    EXPECT_TRUE(outcome.out);
    EXPECT_TRUE(IsAtRest(trace));
    int most = 0;
    std::size_t with_contact = 0;
    float peak = 0;
    for (const TraceSample& sample : trace) {
      most = std::max(most, sample.contact_points);
      with_contact += sample.contact_points > 0 ? 1 : 0;
      peak = std::max(peak, sample.hand_force);
    }
    EXPECT_GE(most, 20);
    EXPECT_GE(10 * with_contact, trace.size());
    EXPECT_GE(peak, 1.0F);
    EXPECT_LE(peak, 20.0F);
  }
  const TraceDivergence divergence = DivergenceOf(demo.traces[0], demo.traces[1]);
  EXPECT_GT(divergence.peak, 1e-3);
  EXPECT_LT(divergence.last, 1e-3);
}

class SharedPart : public ::testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(SharedPart, IsRemovedInContactAtAnyDelay) {
  const auto& [scene, delay_ms] = GetParam();
  const SimulatedDemo demo =
      MustRun(scene, {.seconds = 18, .conditions = {.delay_ms = static_cast<double>(delay_ms)}});
  ExpectWorkedOut(demo);
  // no DDS here: a sample is one frame under way, the answer another
  for (const double measured : demo.mean_delay_s) EXPECT_NEAR(measured, 1e-3 * delay_ms, 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Scenes, SharedPart,
                         ::testing::Combine(::testing::Values("peg_in_slot", "bracket_actuator"),
                                            ::testing::Values(20, 100, 300)),
                         [](const auto& tested) {
                           return std::get<0>(tested.param) + "_at_" +
                                  std::to_string(std::get<1>(tested.param)) + "_ms";
                         });

TEST(SharedPart, IsRemovedUnderJitterAndLoss) {
  const SimulatedDemo demo =
      MustRun("peg_in_slot",
              {.seconds = 18, .conditions = {.delay_ms = 80, .jitter_ms = 40, .loss = 0.05}});
  ExpectWorkedOut(demo);
  EXPECT_GE(demo.mean_delay_s[0], 0.080);
  EXPECT_LE(demo.mean_delay_s[0], 0.125);
}

TEST(SharedPart, IsRemovedUnderTheOtherLaws) {
  for (const char* law : {"p+d", "p+dd", "linear", "pdopt"}) {
    SCOPED_TRACE(law);
    ExpectWorkedOut(MustRun("peg_in_slot", {.seconds = 18, .law = *MakeLaw(law)}));
  }
}

class ThroughTheFixture : public ::testing::TestWithParam<const char*> {};

// Judges by exact geometry. The oracle is not blind: without contact the same hands pull the part
// through.
TEST_P(ThroughTheFixture, PartIsStoppedWithContactAndPassesWithoutIt) {
  constexpr double kPatience = 200;  // s
  const SimulatedDemo with = MustRun(GetParam(), {.seconds = 12});
  const PenetrationReport judged = Penetration(*with.model, 0, with.traces, kPatience);
  EXPECT_LE(judged.max_penetration_voxels, 0.5);
  EXPECT_EQ(judged.poses_checked, judged.poses_given);
  const SimulatedDemo without = MustRun(GetParam(), {.seconds = 12, .contact = false});
  const PenetrationReport report = Penetration(*without.model, 0, without.traces, kPatience);
  EXPECT_GE(report.max_penetration_voxels, 3.0);
  EXPECT_GE(report.overlap_share(), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ThroughTheFixture,
                         ::testing::Values("peg_in_slot", "bracket_actuator"),
                         [](const auto& tested) {
                           return std::string(tested.param);
                         });

// Nothing but contact keeps the nut to its thread: a turn on, along its pitch, and then off.
TEST(SharedPart, NutFollowsItsThreadUnderTwoHands) {
  constexpr double kPitch = 5e-3;   // m
  constexpr double kPlay = 0.3e-3;  // m, from one flank to the other
  constexpr double kWellOn = -0.2;  // turns; farther up little of the thread holds, and it tilts
  const SimulatedDemo demo =
      MustRun("nut_and_bolt", {.seconds = 18, .conditions = {.delay_ms = 100}});
  ExpectWorkedOut(demo);
  ASSERT_EQ(demo.traces.size(), 2U);
  for (const std::vector<TraceSample>& trace : demo.traces) {
    ASSERT_FALSE(trace.empty());
    const Pose& first = trace.front().X_WB;
    double angle = 0;
    double turned = 0;  // turns
    double least = 0;
    double off_thread = 0;
    for (const TraceSample& sample : trace) {
      const Quat q = sample.X_WB.q * first.q.conjugate();
      const double now = 2 * std::atan2(q.z(), q.w());
      turned += std::remainder(now - angle, 2 * M_PI) / (2 * M_PI);
      angle = now;
      least = std::min(least, turned);
      if (least < -0.9 && turned > kWellOn) break;
      off_thread =
          std::max(off_thread, std::abs(sample.X_WB.p.z() - first.p.z() - kPitch * turned));
    }
    EXPECT_LT(least, -0.95);
    EXPECT_LE(off_thread, 0.5 * kPlay + 0.02e-3);
    EXPECT_GE(off_thread, 0.25 * kPlay);  // pressed one way, pulled the other
  }
}

TEST(SharedPart, RunIsDeterministic) {
  const SimulatedDemoOptions options{
      .seconds = 4, .conditions = {.delay_ms = 60, .jitter_ms = 20, .loss = 0.02, .seed = 4}};
  const SimulatedDemo first = MustRun("peg_in_slot", options);
  const SimulatedDemo second = MustRun("peg_in_slot", options);
  for (std::size_t h = 0; h < 2; ++h) {
    ASSERT_EQ(first.traces[h].size(), second.traces[h].size());
    for (std::size_t i = 0; i < first.traces[h].size(); ++i) {
      ASSERT_EQ(first.traces[h][i].X_WB.p, second.traces[h][i].X_WB.p) << i;
      ASSERT_EQ(first.traces[h][i].X_WB.q.coeffs(), second.traces[h][i].X_WB.q.coeffs()) << i;
    }
  }
}

}  // namespace
}  // namespace tandem
