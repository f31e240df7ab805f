#include "collab/trace/path_record.h"

#include <cmath>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kMsInNs = 1e6;

struct Line {
  double there_ms = 20;  // least delays
  double back_ms = 20;
  double jitter_ms = 0;
  double offset_ms = 0;  // the other clock minus ours
  double drift_ppm = 0;
  int samples = 20'000;
};

/// Returns what both ends note down, by the definition: each arrival by its clock minus the sending
/// by the other's. Every hundredth sample is lost there, every fiftieth back.
PathRecord Noted(const Line& line) {
  std::mt19937_64 random(5);
  std::exponential_distribution<double> jitter(1);
  PathRecord record;
  for (int i = 0; i < line.samples; ++i) {
    const double t_ms = i;
    const double offset_ms = line.offset_ms + 1e-6 * line.drift_ppm * t_ms;
    const double there = line.there_ms + line.jitter_ms * jitter(random);
    const double back = line.back_ms + line.jitter_ms * jitter(random);
    const auto ns = [](double ms) {
      return std::llround(kMsInNs * ms);
    };
    record.there_ns.push_back(i % 100 == 7 ? PathRecord::kNever : ns(there + offset_ms));
    record.back_ns.push_back(i % 50 == 3 ? PathRecord::kNever : ns(back - offset_ms));
  }
  return record;
}

TEST(PathRecord, SymmetricLineIsMeasuredForAnyClocks) {
  for (const double offset_ms : {0.0, 123'456.789, -9e9}) {
    SCOPED_TRACE(offset_ms);
    const PathRecord record = Noted({.offset_ms = offset_ms});
    const ClockEstimate clocks = EstimateClocks(record);
    EXPECT_NEAR(static_cast<double>(clocks.offset_ns), kMsInNs * offset_ms, 2048);
    EXPECT_NEAR(clocks.bound_ms, 20, 1e-3);
    const NetworkTrace trace = TraceOf(record, clocks);
    EXPECT_EQ(trace.there_ms[7], NetworkTrace::kLost);
    EXPECT_EQ(trace.back_ms[3], NetworkTrace::kLost);
    EXPECT_NEAR(trace.there_ms[0], 20, 5e-3);
    EXPECT_NEAR(trace.back_ms[0], 20, 5e-3);
    EXPECT_NEAR(trace.clock_bound_ms, 20, 1e-3);
  }
}

// 30 ms there and 10 ms back look like 20 each: the sum is right, and the error is within the
// bound.
TEST(PathRecord, AsymmetricLineHasABoundedErrorAndTheRightSum) {
  for (const double there_ms : {0.0, 10.0, 30.0, 40.0}) {
    SCOPED_TRACE(there_ms);
    const double back_ms = 40 - there_ms;
    const PathRecord record = Noted({.there_ms = there_ms, .back_ms = back_ms, .offset_ms = 5000});
    const ClockEstimate clocks = EstimateClocks(record);
    const NetworkTrace trace = TraceOf(record, clocks);
    EXPECT_NEAR(trace.there_ms[0] + trace.back_ms[0], 40, 1e-2);
    EXPECT_NEAR(clocks.bound_ms, 20, 1e-3);
    EXPECT_LE(std::abs(static_cast<double>(trace.there_ms[0]) - there_ms), clocks.bound_ms + 1e-2);
  }
}

TEST(PathRecord, ClockDriftIsRemoved) {
  // 50 ppm make 3 ms in a minute
  const PathRecord record =
      Noted({.jitter_ms = 2, .offset_ms = -77, .drift_ppm = 50, .samples = 60'000});
  const ClockEstimate clocks = EstimateClocks(record);
  EXPECT_NEAR(clocks.drift_ppm, 50, 1);
  const NetworkTrace trace = TraceOf(record, clocks);
  double first = 0;
  double last = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto at = static_cast<std::size_t>(i);
    first = std::max(first, trace.there_ms[at] >= 0 ? 1.0 / (1.0 + trace.there_ms[at]) : 0.0);
    const std::size_t end = trace.there_ms.size() - 1 - at;
    last = std::max(last, trace.there_ms[end] >= 0 ? 1.0 / (1.0 + trace.there_ms[end]) : 0.0);
  }
  EXPECT_NEAR(1 / first - 1, 20, 0.1);  // least delays
  EXPECT_NEAR(1 / last - 1, 20, 0.1);
}

TEST(PathRecord, JitterAndShortRecordsShowNoDrift) {
  EXPECT_EQ(EstimateClocks(Noted({.jitter_ms = 5})).drift_ppm, 0);
  EXPECT_EQ(EstimateClocks(Noted({.drift_ppm = 50, .samples = 5000})).drift_ppm, 0);
}

TEST(PathRecord, NoEstimateWithoutSamplesInBothDirections) {
  PathRecord record = Noted({});
  record.back_ns.assign(record.back_ns.size(), PathRecord::kNever);
  EXPECT_LT(EstimateClocks(record).bound_ms, 0);
  EXPECT_LT(EstimateClocks({}).bound_ms, 0);
}

}  // namespace
}  // namespace tandem
