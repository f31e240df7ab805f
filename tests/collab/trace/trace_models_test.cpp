#include "collab/trace/trace_models.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "collab/receive/link_trace.h"
#include "collab/trace/trace_file.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

NetworkTrace Made(const std::string& name, double seconds = 120, std::uint64_t seed = 1) {
  Result<NetworkTrace> trace = MakeTrace(name, {.seconds = seconds, .rate_hz = 1000, .seed = seed});
  EXPECT_TRUE(trace);
  return trace ? *trace : NetworkTrace{};
}

/// Returns the round trips of samples that left together and both arrived, rising.
std::vector<double> RoundTrips(const NetworkTrace& trace) {
  std::vector<double> all;
  for (std::size_t i = 0; i < trace.there_ms.size(); ++i) {
    if (trace.there_ms[i] < 0 || trace.back_ms[i] < 0) continue;
    all.push_back(static_cast<double>(trace.there_ms[i]) + static_cast<double>(trace.back_ms[i]));
  }
  std::ranges::sort(all);
  return all;
}

double At(const std::vector<double>& rising, double share) {
  return rising[static_cast<std::size_t>(share * static_cast<double>(rising.size() - 1))];
}

TEST(TraceModels, AreDeterministicPerSeed) {
  for (const TraceModel& model : TraceModels()) {
    SCOPED_TRACE(model.name);
    const NetworkTrace first = Made(model.name, 5);
    const NetworkTrace again = Made(model.name, 5);
    const NetworkTrace other = Made(model.name, 5, 2);
    ASSERT_EQ(first.there_ms.size(), 5000U);
    ASSERT_EQ(first.back_ms.size(), 5000U);
    EXPECT_EQ(first.there_ms, again.there_ms);
    EXPECT_EQ(first.back_ms, again.back_ms);
    EXPECT_NE(first.there_ms, other.there_ms);
    EXPECT_NE(first.back_ms, other.back_ms);
  }
}

// The parts are all queues, which neither reorder nor answer before the least delay.
TEST(TraceModels, KeepTheOrderAndTheLeastDelay) {
  for (const TraceModel& model : TraceModels()) {
    SCOPED_TRACE(model.name);
    const NetworkTrace trace = Made(model.name);
    EXPECT_EQ(LinkTrace(1000, trace.there_ms).facts().overtaken, 0);
    EXPECT_EQ(LinkTrace(1000, trace.back_ms).facts().overtaken, 0);
    for (const float delay : trace.there_ms) {
      if (delay >= 0) {
        EXPECT_GE(delay, model.there.base_ms - 1e-3);
      }
    }
  }
}

// The published figures are those of docs/network-plans.md, with their sources.
TEST(TraceModels, MatchPublishedRoundTrips) {
  // Starlink: median 25.7 ms at peak hours in 2025, less than one in a hundred above 55 ms
  const std::vector<double> leo = RoundTrips(Made("leo", 600));
  EXPECT_NEAR(At(leo, 0.5), 30, 6);
  EXPECT_LT(At(leo, 0.98), 60);
  // geostationary: some 600 ms
  EXPECT_NEAR(At(RoundTrips(Made("geo")), 0.5), 600, 15);
  // New York to London: at most 90 ms in the mean of a month, and no faster than light in glass
  const std::vector<double> atlantic = RoundTrips(Made("transatlantic"));
  EXPECT_LT(At(atlantic, 0.5), 90);
  EXPECT_GT(At(atlantic, 0), 2 * 5570 / 204.0);
  // home Wi-Fi: one in a hundred above some 90 ms
  EXPECT_NEAR(At(RoundTrips(Made("wifi", 600)), 0.99), 90, 45);
}

TEST(TraceModels, LowOrbitHandsOverEveryFifteenSeconds) {
  const NetworkTrace trace = Made("leo", 150);
  // when delays are folded by 15 s, those above the line's usual delay lie in one place
  std::vector<double> sum(150, 0);
  std::vector<int> count(150, 0);
  for (std::size_t i = 0; i < trace.there_ms.size(); ++i) {
    if (trace.there_ms[i] < 0) continue;
    const std::size_t place = i % 15000 / 100;
    sum[place] += static_cast<double>(trace.there_ms[i]);
    ++count[place];
  }
  int high = 0;
  std::vector<double> mean;
  for (std::size_t i = 0; i < sum.size(); ++i) mean.push_back(sum[i] / count[i]);
  std::vector<double> sorted = mean;
  std::ranges::sort(sorted);
  for (const double each : mean) high += each > sorted[75] + 8 ? 1 : 0;
  EXPECT_GE(high, 1);
  EXPECT_LE(high, 4);  // 140 ms and 75 ms of 15 s, in tenths of a second
}

// A buffer of 120 kB at 2 Mbit/s holds 480 ms. CUBIC goes back to 0.7 of the window, of which 40 ms
// are on the line: 0.7 * 520 - 40 = 324 ms.
TEST(TraceModels, UploadFillsTheBufferAsCubicDoes) {
  const NetworkTrace trace = Made("bufferbloat", 120);
  const TraceFacts facts = LinkTrace(1000, trace.there_ms).facts();
  EXPECT_NEAR(facts.longest_ms, 20 + 480, 12);
  std::vector<float> waiting;
  for (const float delay : trace.there_ms) {
    if (delay > 250) waiting.push_back(delay);
  }
  const double share =
      static_cast<double>(waiting.size()) / static_cast<double>(trace.there_ms.size());
  EXPECT_NEAR(share, 2.0 / 3.0, 0.05);
  EXPECT_NEAR(static_cast<double>(*std::ranges::min_element(waiting)), 250, 5);  // it drains
  EXPECT_LT(LinkTrace(1000, trace.back_ms).facts().longest_ms, 60);
}

TEST(TraceModels, RefuseImpossibleParameters) {
  const Result<NetworkTrace> unknown = MakeTrace("6g", {});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().what, HasSubstr("there are wifi, lte"));
  EXPECT_FALSE(MakeTrace("wifi", {.seconds = 1e6}));
  EXPECT_FALSE(MakeTrace("wifi", {.seconds = NAN}));
}

}  // namespace
}  // namespace tandem
