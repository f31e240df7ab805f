// Tests ways beyond what there is room for. A pose tells its number by where it is: a millimetre
// and a bit from one to the next, so that each is kept.
#include "engine/haptics/path_backtracker.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kApart = 1.05e-3;  // m

Pose Numbered(int number, double y) {
  return {Quat::Identity(), Vec3(kApart * number, y, 0)};
}

/// Moves a part in a hand along the line at `y`, from one number to another.
void Move(PathBacktracker& way, int body, int from, int to, double y) {
  way.Begin(body, 0.1, Numbered(from, y));
  for (int i = from + 1; i < to; ++i) way.Note(Numbered(i, y));
}

/// Goes back with a part that follows at once, and returns where it ends. Every goal is on the line
/// at `y`, at most as far on as the one before.
Pose Back(PathBacktracker& way, Pose X_WB, double y) {
  way.SetOut(X_WB);
  for (int i = 0; i < 200'000 && way.state() == PathBacktracker::State::kUnderWay; ++i) {
    way.Advance(X_WB);
    const Pose& goal = way.goal();
    EXPECT_NEAR(goal.p.y(), y, 1e-12) << "a goal on the way of another part";
    EXPECT_LE(goal.p.x(), X_WB.p.x() + 1e-12) << "a goal further on than the part";
    EXPECT_GE(goal.p.x(), X_WB.p.x() - PathBacktracker::kLead - kApart)
        << "a goal far from the part";
    if (::testing::Test::HasFailure()) break;
    X_WB = goal;
  }
  return X_WB;
}

constexpr int kRoom = static_cast<int>(PathBacktracker::kMost);

TEST(PathBacktracker, LeadsAStoredPathToItsStart) {
  PathBacktracker way;
  Move(way, 1, 0, kRoom, 0);
  EXPECT_FALSE(way.cut());
  EXPECT_NEAR(Back(way, Numbered(kRoom - 1, 0), 0).p.x(), 0, 1e-9);
  EXPECT_EQ(way.state(), PathBacktracker::State::kArrived);
}

TEST(PathBacktracker, LeadsATruncatedPathToItsOldestPoseAndSaysSo) {
  PathBacktracker way;
  Move(way, 1, 0, 20'000, 0);
  EXPECT_TRUE(way.cut());
  const Pose end = Back(way, Numbered(19'999, 0), 0);
  EXPECT_NEAR(end.p.x(), kApart * (20'000 - kRoom), 1e-9);
  EXPECT_EQ(way.state(), PathBacktracker::State::kCut);
}

TEST(PathBacktracker, OverwrittenPathIsForgottenAfterALongDrop) {
  PathBacktracker way;
  Move(way, 1, 0, 100, 1);
  Move(way, 2, 0, 20'000, 0);  // over all of the first
  way.Drop();
  EXPECT_EQ(way.body(), -1);
  way.SetOut(Numbered(99, 1));
  EXPECT_EQ(way.state(), PathBacktracker::State::kNotHere);
  // and what comes next is whole
  Move(way, 3, 0, 50, 2);
  EXPECT_FALSE(way.cut());
  EXPECT_NEAR(Back(way, Numbered(49, 2), 2).p.x(), 0, 1e-9);
  EXPECT_EQ(way.state(), PathBacktracker::State::kArrived);
}

TEST(PathBacktracker, PartlyOverwrittenPathIsTruncatedAfterADrop) {
  PathBacktracker way;
  Move(way, 1, 0, 10'000, 1);
  Move(way, 2, 0, 10'000, 0);
  way.Drop();
  EXPECT_EQ(way.body(), 1);
  EXPECT_TRUE(way.cut());
  const Pose end = Back(way, Numbered(9'999, 1), 1);
  EXPECT_NEAR(end.p.x(), kApart * (20'000 - kRoom), 1e-9);
  EXPECT_EQ(way.state(), PathBacktracker::State::kCut);
}

// The part goes half the way back and on again. A place that was overwritten once stays forgotten.
TEST(PathBacktracker, ReturnAndAdvanceDoNotRestoreOverwrittenPoses) {
  PathBacktracker way;
  Move(way, 1, 0, 20'000, 0);
  Pose X_WB = Numbered(19'999, 0);
  way.SetOut(X_WB);
  while (X_WB.p.x() > kApart * 12'000) {
    way.Advance(X_WB);
    X_WB = way.goal();
  }
  way.Stop();
  Move(way, 2, 0, 1'000, 1);
  way.Drop();
  EXPECT_TRUE(way.cut());
  const Pose end = Back(way, X_WB, 0);
  EXPECT_NEAR(end.p.x(), kApart * (20'000 - kRoom), 1e-9);
  EXPECT_EQ(way.state(), PathBacktracker::State::kCut);
}

}  // namespace
}  // namespace tandem
