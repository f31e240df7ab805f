#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "collab/lab/run/case_run.h"
#include "collab/trace/trace_models.h"
#include "tests/stability/free_box.h"

// Tests networks as they are: a run over a trace is the run over what the trace was taken of.
namespace tandem {
namespace {

using testing::FreeBox;
using testing::HandOfBox;

LabCase Move(double delay_s) {
  LabCase test;
  test.hands = {HandOfBox("relaxed")};
  test.motion = LabMotion::kMove;
  test.delay_s = delay_s;
  test.seconds = 6;
  return test;
}

/// Returns what the conditions do to samples at 1 kHz, as a receiver would note it down.
std::vector<float> Noted(const LinkConditions& conditions, int samples) {
  LinkConditioner link(conditions);
  std::vector<float> delays;
  for (int i = 0; i < samples; ++i) {
    std::array<std::int64_t, 2> due_ns{};
    const std::int64_t sent_ns = i * 1'000'000LL;
    delays.push_back(link.Due(sent_ns, due_ns) == 0
                         ? -1.0F
                         : static_cast<float>(1e-6 * static_cast<double>(due_ns[0] - sent_ns)));
  }
  return delays;
}

CaseResult OverTraces(LabCase test, const LinkTrace& there, const LinkTrace& back) {
  test.delay_s = 0;
  test.network = {};
  test.network.there.trace = &there;
  test.network.back.trace = &back;
  return RunCase(test, FreeBox());
}

TEST(TraceRuns, ConstantTraceEqualsAConstantDelay) {
  for (const double delay_s : {0.02, 0.1, 0.3}) {
    SCOPED_TRACE(delay_s);
    const LabCase test = Move(delay_s);
    const LinkTrace even(1000, std::vector<float>(1000, static_cast<float>(1e3 * delay_s)));
    const CaseResult plan = RunCase(test, FreeBox());
    const CaseResult trace = OverTraces(test, even, even);
    ASSERT_FALSE(plan.fault);
    ASSERT_FALSE(trace.fault);
    EXPECT_EQ(trace.verdict, plan.verdict);
    EXPECT_NEAR(trace.metrics.peak_apart, plan.metrics.peak_apart, 1e-6);
    EXPECT_NEAR(trace.metrics.peak_force, plan.metrics.peak_force, 1e-3);
  }
}

TEST(TraceRuns, TraceOfJitterAndLossMatchesThemWithinTwoPercent) {
  LabCase test = Move(0.06);
  test.network.there = test.network.back = {.jitter_ms = 20, .loss = 0.05};
  const LinkTrace there(1000,
                        Noted({.delay_ms = 60, .jitter_ms = 20, .loss = 0.05, .seed = 8}, 20'000));
  const LinkTrace back(1000,
                       Noted({.delay_ms = 60, .jitter_ms = 20, .loss = 0.05, .seed = 9}, 20'000));
  const CaseResult plan = RunCase(test, FreeBox());
  const CaseResult trace = OverTraces(test, there, back);
  ASSERT_FALSE(plan.fault);
  ASSERT_FALSE(trace.fault);
  EXPECT_EQ(trace.verdict, plan.verdict);
  EXPECT_NEAR(trace.metrics.peak_apart / plan.metrics.peak_apart, 1, 0.02);
  EXPECT_NEAR(trace.metrics.peak_force / plan.metrics.peak_force, 1, 0.02);
}

TEST(TraceRuns, AreDeterministicPerStartPosition) {
  LabCase test = Move(0);
  test.network.there.trace = *KeepModel("leo", TraceDirection::kThere, 1);
  test.network.back.trace = *KeepModel("leo", TraceDirection::kBack, 1);
  const CaseResult first = RunCase(test, FreeBox());
  ASSERT_FALSE(first.fault);
  EXPECT_EQ(RunCase(test, FreeBox()).digest, first.digest);
  test.network.traced = {.there = test.network.there.trace, .start_s = 14};
  EXPECT_NE(RunCase(test, FreeBox()).digest, first.digest);
}

}  // namespace
}  // namespace tandem
