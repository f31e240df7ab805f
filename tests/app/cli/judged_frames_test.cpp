#include "app/cli/judged_frames.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kOrigin = 77;

std::int64_t At(double ms) {
  return kOrigin + static_cast<std::int64_t>(ms * kMs);
}

TEST(JudgedFrames, CountsOnlyFramesThatAreJudged) {
  JudgedFrames frames(kOrigin, kMs);
  frames.Add(false, At(1), At(1.9), 900'000);
  frames.Add(true, At(2), At(2.3), 250'000);
  frames.Add(true, At(3.1), At(3.2), 100'000);
  frames.Add(false, At(4), At(4.9), 900'000);
  EXPECT_EQ(frames.stats().frames(), 2U);
  EXPECT_EQ(frames.stats().missed(), 0U);
  EXPECT_EQ(frames.stats().cpu().max(), 250'000);
  EXPECT_EQ(frames.stats().wall().max(), 300'000);
  EXPECT_EQ(frames.stats().lateness().max(), 100'000);
}

// The deadlines that pass between two judged frames, whichever of them was late. Those before the
// first judged frame are of another time.
TEST(JudgedFrames, CountsTheDeadlinesBetweenThem) {
  JudgedFrames frames(kOrigin, kMs);
  frames.Add(false, At(1), At(4.5), kMs);
  frames.Add(true, At(5), At(7.5), 2 * kMs);  // 6 and 7 are missed
  frames.Add(true, At(8), At(8.1), 50'000);
  frames.Add(true, At(10.4), At(10.5), 50'000);  // late for 9, so 10 gets no frame
  frames.Add(true, At(11), At(11.1), 50'000);
  EXPECT_EQ(frames.stats().frames(), 4U);
  EXPECT_EQ(frames.stats().missed(), 3U);
  EXPECT_EQ(frames.over_period(), 1U);
}

}  // namespace
}  // namespace tandem
