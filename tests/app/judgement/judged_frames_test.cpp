#include "app/judgement/judged_frames.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

constexpr std::int64_t kOriginNs = 77;

std::int64_t AtMs(double ms) {
  return kOriginNs + static_cast<std::int64_t>(ms * kMs);
}

TEST(JudgedFrames, CountsOnlyFramesThatAreJudged) {
  JudgedFrames frames(kOriginNs, kMs);
  frames.Add(false, AtMs(1), AtMs(1.9), 900'000);
  frames.Add(true, AtMs(2), AtMs(2.3), 250'000);
  frames.Add(true, AtMs(3.1), AtMs(3.2), 100'000);
  frames.Add(false, AtMs(4), AtMs(4.9), 900'000);
  EXPECT_EQ(frames.stats().frames(), 2U);
  EXPECT_EQ(frames.stats().missed(), 0U);
  EXPECT_EQ(frames.stats().cpu().max(), 250'000);
  EXPECT_EQ(frames.stats().wall().max(), 300'000);
  EXPECT_EQ(frames.stats().lateness().max(), 100'000);
}

// Deadlines count that pass between two judged frames, whichever of the frames was late. Deadlines
// before the first judged frame do not.
TEST(JudgedFrames, CountsTheDeadlinesBetweenThem) {
  JudgedFrames frames(kOriginNs, kMs);
  frames.Add(false, AtMs(1), AtMs(4.5), kMs);
  frames.Add(true, AtMs(5), AtMs(7.5), 2 * kMs);  // 6 and 7 are missed
  frames.Add(true, AtMs(8), AtMs(8.1), 50'000);
  frames.Add(true, AtMs(10.4), AtMs(10.5), 50'000);  // late for 9, so 10 gets no frame
  frames.Add(true, AtMs(11), AtMs(11.1), 50'000);
  EXPECT_EQ(frames.stats().frames(), 4U);
  EXPECT_EQ(frames.stats().missed(), 3U);
  EXPECT_EQ(frames.over_period(), 1U);
}

}  // namespace
}  // namespace tandem
