#include "collab/separation/return_path.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/world/world.h"

namespace tandem {
namespace {

constexpr PeerId kOtherPeer = 7;
constexpr double kRadius = 0.02;

/// Two paths that start at the origin. After a second ours goes left and down, theirs right and
/// down, and from y = -0.05 on something is between them.
struct DivergingPaths {
  DivergingPaths() : history(true) {
    for (int i = 0; i < 400; ++i) {
      const double t = 0.01 * i;
      const double aside = 0.1 * std::clamp(t - 1.0, 0.0, 1.0);
      const double down = 0.2 * std::clamp(t - 2.0, 0.0, 1.0);
      Add(Vec3(-aside, -down, 0), Vec3(aside, -down, 0), down > 0.05);
    }
  }
  void Add(const Vec3& ours, const Vec3& theirs, bool blocked, bool received = true) {
    PoseHistory::Moment& moment = history.Add();
    moment.ours = {Quat::Identity(), ours};
    moment.count = received ? 1 : 0;
    moment.others[0] = {kOtherPeer, {Quat::Identity(), theirs}};
    moment.blocked[0] = blocked;
  }
  PoseHistory history;
};

/// Returns whether there is a way. If there is, `way` is at its beginning.
bool Begin(ReturnPath& way, const PoseHistory& history, PeerId towards, const Pose& X_WB) {
  way.Start(history, towards, kRadius);
  while (way.state() == ReturnPath::State::kSearching) way.Search(history);
  way.SetOut(history, X_WB);
  return way.state() == ReturnPath::State::kUnderWay;
}

TEST(ReturnPath, ReturnsByOwnPathThenFollowsTheCoupledPeers) {
  DivergingPaths separation;
  ReturnPath way;
  Pose X_WB = separation.history.Ours(separation.history.end() - 1);
  ASSERT_TRUE(Begin(way, separation.history, kOtherPeer, X_WB));
  double highest = -1;
  double fastest = 0;
  int frames = 0;
  for (; frames < 10000 && way.state() == ReturnPath::State::kUnderWay; ++frames) {
    const Vec3 before = way.goal().p;
    way.Advance(separation.history, X_WB);
    X_WB = way.goal();
    fastest = std::max(fastest, (X_WB.p - before).norm() / kFrame);
    highest = std::max(highest, X_WB.p.y());
    // on one of the two paths, or between them where they were together
    const bool on_ours = std::abs(X_WB.p.x() + 0.1) < 1e-9;
    const bool on_theirs = std::abs(X_WB.p.x() - 0.1) < 1e-9;
    EXPECT_TRUE(on_ours || on_theirs || std::abs(X_WB.p.y()) < 1e-9) << X_WB.p.transpose();
  }
  EXPECT_EQ(way.state(), ReturnPath::State::kArrived);
  EXPECT_LT((X_WB.p - Vec3(0.1, -0.2, 0)).norm(), ReturnPath::kThere + 1e-9);
  EXPECT_NEAR(highest, 0.0, 1e-9);
  EXPECT_LE(fastest, ReturnPath::kSpeed + 1e-6);
  EXPECT_NEAR(frames * kFrame, 0.6 / ReturnPath::kSpeed, 0.15);
}

TEST(ReturnPath, WaitsForABlockedBodyThenGivesUp) {
  DivergingPaths separation;
  ReturnPath way;
  const Pose X_WB = separation.history.Ours(separation.history.end() - 1);
  ASSERT_TRUE(Begin(way, separation.history, kOtherPeer, X_WB));
  for (int i = 0; i < 2900; ++i) way.Advance(separation.history, X_WB);
  EXPECT_EQ(way.state(), ReturnPath::State::kUnderWay);
  EXPECT_LT((way.goal().p - X_WB.p).norm(), ReturnPath::kLead + 1e-3);
  for (int i = 0; i < 300; ++i) way.Advance(separation.history, X_WB);
  EXPECT_EQ(way.state(), ReturnPath::State::kStuck);
}

TEST(ReturnPath, FollowsAMovingCoupledPeer) {
  DivergingPaths separation;
  ReturnPath way;
  Pose X_WB = separation.history.Ours(separation.history.end() - 1);
  ASSERT_TRUE(Begin(way, separation.history, kOtherPeer, X_WB));
  for (int i = 0; i < 10000 && way.state() == ReturnPath::State::kUnderWay; ++i) {
    const double on = 0.05 * std::min(3.0, 1e-3 * i);
    if (i % 10 == 0) separation.Add(X_WB.p, Vec3(0.1, -0.2, on), true);
    way.Advance(separation.history, X_WB);
    X_WB = way.goal();
  }
  EXPECT_EQ(way.state(), ReturnPath::State::kArrived);
  EXPECT_GT(X_WB.p.z(), 0.1);
}

// The hand feels nothing on the way, so the way may not last for ever.
TEST(ReturnPath, GivesUpOnAFasterCoupledPeer) {
  DivergingPaths separation;
  ReturnPath way;
  Pose X_WB = separation.history.Ours(separation.history.end() - 1);
  ASSERT_TRUE(Begin(way, separation.history, kOtherPeer, X_WB));
  int frames = 0;
  for (; frames < 30'000 && way.state() == ReturnPath::State::kUnderWay; ++frames) {
    const double round = 5.0 * 1e-3 * frames;  // rad: 0.5 m/s
    const Vec3 aside(0.1 * std::cos(round), -0.2 + 0.1 * std::sin(round), 0);
    if (frames % 10 == 0) separation.Add(X_WB.p, aside, true);
    way.Advance(separation.history, X_WB);
    X_WB = way.goal();
  }
  EXPECT_EQ(way.state(), ReturnPath::State::kStuck);
  EXPECT_NEAR(frames * kFrame, 15, 0.1);
}

TEST(ReturnPath, HasNoPathToACoupledPeerThatWasNeverNear) {
  PoseHistory history(true);
  for (int i = 0; i < 100; ++i) {
    PoseHistory::Moment& moment = history.Add();
    moment.ours = {};
    moment.count = 1;
    moment.others[0] = {kOtherPeer, {Quat::Identity(), Vec3(0.1, 0, 0)}};
    moment.blocked[0] = true;
  }
  ReturnPath way;
  EXPECT_FALSE(Begin(way, history, kOtherPeer, {}));
  EXPECT_FALSE(Begin(way, history, kOtherPeer + 1, {}));
}

// A haptic frame is short: a long history is gone through in many.
TEST(ReturnPath, SearchesABoundedHistoryPerFrame) {
  DivergingPaths separation;
  for (int i = 0; i < 3300; ++i) separation.Add(Vec3(-0.1, 0, 0), Vec3(0.1, 0, 0), true);
  ReturnPath way;
  way.Start(separation.history, kOtherPeer, kRadius);
  int frames = 0;
  for (; frames < 1000 && way.state() == ReturnPath::State::kSearching; ++frames) {
    way.Search(separation.history);
  }
  // 3000 moments, none of them free
  EXPECT_EQ(way.state(), ReturnPath::State::kNoWay);
  EXPECT_EQ(frames, 3000 / ReturnPath::kMostMoments + 1);
}

// Before it sets out the body moves on: the way begins where it then is.
TEST(ReturnPath, StartsAtTheBodysCurrentPose) {
  DivergingPaths separation;
  ReturnPath way;
  way.Start(separation.history, kOtherPeer, kRadius);
  while (way.state() == ReturnPath::State::kSearching) way.Search(separation.history);
  ASSERT_EQ(way.state(), ReturnPath::State::kFound);
  Pose X_WB = separation.history.Ours(separation.history.end() - 1);
  for (int i = 0; i < 20; ++i) {
    X_WB.p.y() -= 0.005;
    separation.Add(X_WB.p, Vec3(0.1, -0.2, 0), true);
  }
  way.SetOut(separation.history, X_WB);
  EXPECT_EQ(way.goal().p, X_WB.p);
  way.Advance(separation.history, X_WB);
  EXPECT_LE((way.goal().p - X_WB.p).norm(), ReturnPath::kSpeed * kFrame + 1e-9);
  // the way leads back along the body's own path, with what it went meanwhile
  EXPECT_EQ(way.goal().p.x(), X_WB.p.x());
}

TEST(ReturnPath, StopsWhenTheCoupledPeerIsGone) {
  DivergingPaths separation;
  ReturnPath way;
  const Pose X_WB = separation.history.Ours(separation.history.end() - 1);
  ASSERT_TRUE(Begin(way, separation.history, kOtherPeer, X_WB));
  separation.Add(X_WB.p, Vec3::Zero(), false, false);
  way.Advance(separation.history, X_WB);
  EXPECT_EQ(way.state(), ReturnPath::State::kStuck);
}

TEST(PoseHistory, KeepsTheLastThirtySeconds) {
  PoseHistory history(true);
  for (int i = 0; i < 4000; ++i) history.Add().ours.p.x() = i;
  EXPECT_EQ(history.end() - history.begin(), 3000);
  EXPECT_EQ(history.Ours(history.end() - 1).p.x(), 3999);
  EXPECT_EQ(history.Ours(history.begin()).p.x(), 1000);
}

}  // namespace
}  // namespace tandem
