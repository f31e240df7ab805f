#include "collab/dds/networks/network_watch.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kMinute = 60'000 * kMillisecond;

TEST(PauseDetector, TurnsWithoutPauseAreNone) {
  PauseDetector detector(0, 5 * kMinute);
  for (std::int64_t ms = 500; ms < 600'000; ms += 500) {
    ASSERT_FALSE(detector.Paused(ms * kMillisecond, 5 * kMinute + ms * kMillisecond)) << ms;
  }
}

// A machine that sleeps stops the first clock alone.
TEST(PauseDetector, SleepOfTenMinutesIsSeenOnce) {
  PauseDetector detector(0, 0);
  EXPECT_FALSE(detector.Paused(500 * kMillisecond, 500 * kMillisecond));
  EXPECT_TRUE(detector.Paused(600 * kMillisecond, 10 * kMinute));
  EXPECT_FALSE(detector.Paused(1100 * kMillisecond, 10 * kMinute + 500 * kMillisecond));
}

TEST(PauseDetector, StoppedProgramIsSeen) {
  PauseDetector detector(0, 0);
  EXPECT_TRUE(detector.Paused(3000 * kMillisecond, 3000 * kMillisecond));
  EXPECT_FALSE(detector.Paused(3500 * kMillisecond, 3500 * kMillisecond));
}

}  // namespace
}  // namespace tandem
