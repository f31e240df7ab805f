#include "collab/receive/link_trace.h"

#include <array>
#include <optional>
#include <vector>

#include <gmock/gmock.h>

#include "collab/receive/link_conditioner.h"
#include "engine/base/units.h"
#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;

/// Returns when each of so many samples arrives, sent every `step_ms`, in ms after the first was
/// sent; nothing: it never does.
std::vector<std::optional<double>> Arrivals(const LinkConditions& conditions, int count,
                                            int step_ms = 1) {
  constexpr std::int64_t kBegin = 777 * kMs;
  LinkConditioner link(conditions);
  std::vector<std::optional<double>> all;
  for (int i = 0; i < count; ++i) {
    std::array<std::int64_t, 2> due_ns{};
    const std::size_t copies = link.Due(kBegin + i * step_ms * kMs, due_ns);
    all.push_back(copies == 0 ? std::nullopt
                              : std::optional(1e-6 * static_cast<double>(due_ns[0] - kBegin)));
  }
  return all;
}

TEST(LinkTrace, AppliesItsSamplesCyclically) {
  const LinkTrace trace(1000, {5, -1, 7.5});
  // the fourth, sent at 3 ms with 5 ms, waits for the third: where it begins again it has no order
  EXPECT_THAT(Arrivals({.trace = &trace}, 6),
              ElementsAre(5, std::nullopt, 9.5, 9.5, std::nullopt, 12.5));
}

TEST(LinkTrace, KeepsItsOrder) {
  // the second sample arrives at 31 ms, after the third at 12 ms and the fourth at 13 ms
  const LinkTrace trace(1000, {10, 30, 10, 10});
  EXPECT_FALSE(trace.samples()[0].overtaken);
  EXPECT_TRUE(trace.samples()[1].overtaken);
  EXPECT_FALSE(trace.samples()[2].overtaken);
  EXPECT_THAT(Arrivals({.trace = &trace}, 4), ElementsAre(10, 31, 12, 13));
}

TEST(LinkTrace, AddedJitterKeepsTheOrder) {
  const LinkTrace trace(1000, std::vector<float>(400, 20));
  double latest = 0;
  for (const std::optional<double>& arrival :
       Arrivals({.jitter_ms = 30, .seed = 3, .trace = &trace}, 400)) {
    ASSERT_TRUE(arrival);
    EXPECT_GE(*arrival, latest);
    latest = *arrival;
  }
}

TEST(LinkTrace, ScalesAndStartsAsConfigured) {
  const LinkTrace trace(1000, {5, 10, -1, 20}, 2.0);
  EXPECT_THAT(Arrivals({.delay_ms = 1, .trace = &trace, .trace_start_s = 0.001}, 3),
              ElementsAre(21, std::nullopt, 43));
}

TEST(LinkTrace, OtherSampleRatesUseTheLastSentSample) {
  const LinkTrace slow(500, {10, -1, 30});
  EXPECT_THAT(Arrivals({.trace = &slow}, 6),
              ElementsAre(10, 11, std::nullopt, std::nullopt, 34, 35));
  const LinkTrace fast(1000, {10, -1, 30, 40});
  EXPECT_THAT(Arrivals({.trace = &fast}, 2, 2), ElementsAre(10, 32));
}

TEST(LinkTrace, ContinuesAcrossPlanSteps) {
  const LinkTrace trace(1000, {10, 20, 30, 40});
  LinkConditioner link({.trace = &trace});
  std::array<std::int64_t, 2> due_ns{};
  ASSERT_EQ(link.Due(0, due_ns), 1U);
  link.Switch({.delay_ms = 100, .trace = &trace});
  ASSERT_EQ(link.Due(2 * kMs, due_ns), 1U);
  EXPECT_EQ(due_ns[0], 132 * kMs);
  // another begins with the next sample, and so does this one after it
  const LinkTrace other(1000, {1, 2});
  link.Switch({.trace = &other});
  ASSERT_EQ(link.Due(501 * kMs, due_ns), 1U);
  EXPECT_EQ(due_ns[0], 502 * kMs);
}

TEST(LinkTrace, BackwardClockStepStaysWithinTheTrace) {
  const LinkTrace trace(1000, {1, 2, 3, 4});
  EXPECT_EQ(trace.At(0).delay_ms, 1);
  EXPECT_EQ(trace.At(-1 * kMs).delay_ms, 4);
  EXPECT_EQ(trace.At(-9 * kMs).delay_ms, 4);
  EXPECT_EQ(trace.At(1'000'000'000'000 + 2 * kMs).delay_ms, 3);
}

TEST(LinkTrace, ConditionsAllocateNothing) {
  const LinkTrace trace(1000, {1, -1, 3, 4});
  LinkConditioner link({.jitter_ms = 3, .trace = &trace});
  std::array<std::int64_t, 2> due_ns{};
  const testing::AllocationCounter counter;
  for (int i = 0; i < 1000; ++i) link.Due(i * kMs, due_ns);
  EXPECT_EQ(counter.count(), 0);
}

// By hand: one sample in ten is lost, the others take 20 ms; so for nine in ten milliseconds the
// newest is 20 to 21 ms old, and in one 21 to 22 ms.
TEST(LinkTrace, AgesAreThoseOfTheNewestReceivedSample) {
  std::vector<float> delays(1000, 20);
  for (std::size_t i = 5; i < delays.size(); i += 10) delays[i] = -1;
  const TraceFacts facts = LinkTrace(1000, delays).facts();
  EXPECT_NEAR(facts.loss, 0.1, 1e-12);
  EXPECT_NEAR(facts.mean_delay_ms, 20, 1e-6);
  EXPECT_NEAR(facts.mean_age_ms, 20.6, 0.01);
  EXPECT_NEAR(facts.peak_age_ms, 22, 1e-6);
}

// The oracle asks at every hundredth of a millisecond which samples have arrived.
TEST(LinkTrace, AgesWithReorderingMatchFrequentSampling) {
  std::vector<float> delays;
  std::uint32_t state = 12345;
  for (int i = 0; i < 300; ++i) {
    state = state * 1664525U + 1013904223U;
    const float random = static_cast<float>(state >> 8U) / 16777216.0F;
    delays.push_back(random < 0.2F ? -1.0F : 10.0F + 15.0F * random);
  }
  const LinkTrace trace(1000, delays);
  double sum = 0;
  double peak = 0;
  int exact_queries = 0;
  for (double now = 300; now < 600; now += 0.01, ++exact_queries) {
    double newest = -1e9;
    for (int i = 0; i < 600; ++i) {
      const float delay = delays[static_cast<std::size_t>(i % 300)];
      if (delay >= 0 && i + static_cast<double>(delay) <= now) newest = std::max(newest, 1.0 * i);
    }
    sum += now - newest;
    peak = std::max(peak, now - newest);
  }
  EXPECT_NEAR(trace.facts().mean_age_ms, sum / exact_queries, 0.05);
  EXPECT_NEAR(trace.facts().peak_age_ms, peak, 0.05);
}

}  // namespace
}  // namespace tandem
