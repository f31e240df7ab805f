#include "app/judgement/demo_judgement.h"

#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

std::vector<TraceSample> TraceAt(std::initializer_list<int> times_ms) {
  std::vector<TraceSample> trace;
  for (const int time_ms : times_ms) trace.emplace_back().time_ns = 1'000'000L * time_ms;
  return trace;
}

TEST(DemoJudgement, HandFallsBehindByEachFrameThatItsPeerMisses) {
  // the first peer misses the deadline at 12 ms, the second one those at 13, 14 and 16 ms
  const auto [least_s, most_s] =
      HandsApart(TraceAt({10, 11, 13, 14, 15, 16}), TraceAt({10, 11, 12, 15, 17, 18, 19}));
  EXPECT_DOUBLE_EQ(least_s, -0.001);
  EXPECT_DOUBLE_EQ(most_s, 0.002);
}

}  // namespace
}  // namespace tandem
