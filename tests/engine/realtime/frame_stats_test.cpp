#include "engine/realtime/frame_stats.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(FrameStats, KeepsTheThreeTimesAndTheSkippedDeadlinesApart) {
  FrameStats stats;
  stats.Add(10, 20, 30, 0);
  stats.Add(11, 21, 31, 2);
  EXPECT_EQ(stats.frames(), 2U);
  EXPECT_EQ(stats.missed(), 2U);
  EXPECT_EQ(stats.lateness().max(), 11);
  EXPECT_EQ(stats.cpu().max(), 21);
  EXPECT_EQ(stats.wall().max(), 31);
  EXPECT_EQ(stats.lateness().Quantile(0.5), 10);
  EXPECT_EQ(stats.cpu().Quantile(0.5), 20);
  EXPECT_EQ(stats.wall().Quantile(0.5), 30);
}

TEST(FrameStats, SummaryIsInMicroseconds) {
  FrameStats stats;
  stats.Add(1500, 2500, 3500, 7);
  EXPECT_EQ(stats.Summary(),
            "1 frames, 7 missed, cpu 2.5 / 2.5 / 2.5 us, wall 3.5 / 3.5 / 3.5 us, "
            "late 1.5 / 1.5 / 1.5 us");
}

}  // namespace
}  // namespace tandem
