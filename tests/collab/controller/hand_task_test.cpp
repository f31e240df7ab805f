#include "collab/controller/hand_task.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/collab/controller/fake_peer.h"

namespace tandem {
namespace {

using testing::FakePeer;
using testing::FourBodies;

class HandTaskTest : public ::testing::Test {
 protected:
  std::optional<HandTask::Ended> Run(std::int64_t ms) {
    for (std::int64_t i = 0; i < ms; ++i) {
      now_ns_ += kMs;
      task_.OnFacts(peer_.facts, scene_, now_ns_);
      if (std::optional<HandTask::Ended> ended = task_.TakeEnded()) return ended;
    }
    return std::nullopt;
  }
  void TakePeg() {
    task_.Take(0, {.body = "peg"}, scene_, now_ns_);
    const std::optional<HandTask::Ended> taken = Run(10);
    ASSERT_TRUE(taken && taken->ok);
  }

  ControlScene scene_ = FourBodies();
  FakePeer peer_;
  HandTask task_{peer_};
  std::int64_t now_ns_ = 0;
};

TEST_F(HandTaskTest, ReturnsToTheGraspPoseAndKeepsHolding) {
  TakePeg();
  task_.GoBack(RetraceRequest::To::kGrasp, now_ns_);
  EXPECT_FALSE(Run(500)) << "on the way";
  EXPECT_TRUE(task_.going_back());
  peer_.facts.way = PathBacktracker::State::kArrived;
  const std::optional<HandTask::Ended> ended = Run(2);
  ASSERT_TRUE(ended);
  EXPECT_TRUE(ended->ok);
  EXPECT_EQ(peer_.facts.held, 0);
}

TEST_F(HandTaskTest, UndoGrabsTheReleasedPartAndReturnsIt) {
  TakePeg();
  task_.LetGo(now_ns_);
  ASSERT_TRUE(Run(10)->ok);
  task_.GoBack(RetraceRequest::To::kUndo, now_ns_);
  EXPECT_FALSE(Run(10));
  EXPECT_EQ(peer_.facts.held, 0) << "taken again";
  EXPECT_TRUE(peer_.goal.keeps_way);
  peer_.facts.way = PathBacktracker::State::kArrived;
  const std::optional<HandTask::Ended> ended = Run(10);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->reason, "peg is back");
  EXPECT_EQ(peer_.facts.held, -1);
  EXPECT_EQ(peer_.facts.way_body, -1) << "that way is forgotten";
  task_.GoBack(RetraceRequest::To::kUndo, now_ns_);
  EXPECT_EQ(Run(10)->reason, "there is nothing to undo");
}

TEST_F(HandTaskTest, BlockedPartStopsAndReportsIt) {
  TakePeg();
  task_.GoBack(RetraceRequest::To::kUndo, now_ns_);
  Run(10);
  peer_.facts.way = PathBacktracker::State::kStuck;
  const std::optional<HandTask::Ended> ended = Run(10);
  ASSERT_TRUE(ended);
  EXPECT_FALSE(ended->ok);
  EXPECT_EQ(ended->reason, "peg stopped on its way back: something blocks it");
  EXPECT_EQ(peer_.facts.way_body, 0) << "the rest of the way is kept, for another try";
}

TEST_F(HandTaskTest, ResetLeadsEachBodyHomeWhoeverMovedIt) {
  peer_.follows = true;
  Run(1);
  // by others: the peg in steps, the bolt at once
  for (int i = 1; i <= 50; ++i) {
    peer_.facts.bodies[0].X_WB.p = Vec3(1e-3 * i, 0, 0);
    Run(1);
  }
  peer_.facts.bodies[1].X_WB.p = Vec3(0, 0.03, 0);
  Run(1);
  task_.GoBack(RetraceRequest::To::kReset, now_ns_);
  const std::int64_t begun_ns = now_ns_;
  const std::optional<HandTask::Ended> ended = Run(2000);
  ASSERT_TRUE(ended);
  EXPECT_TRUE(ended->ok);
  EXPECT_EQ(ended->reason, "2 bodies went back");
  for (int body : {0, 1}) EXPECT_LT(peer_.facts.bodies[body].X_WB.p.norm(), 3e-4) << body;
  EXPECT_EQ(peer_.facts.held, -1);
  EXPECT_EQ(peer_.facts.way_body, -1) << "there is nothing to undo";
  // 80 mm at 0.25 m/s take 0.32 s
  EXPECT_GT(now_ns_ - begun_ns, 320 * kMs);
}

TEST_F(HandTaskTest, ResetNamesBodiesThatOthersHold) {
  peer_.follows = true;
  Run(1);
  peer_.facts.bodies[0].X_WB.p = Vec3(0.02, 0, 0);
  peer_.facts.bodies[1].X_WB.p = Vec3(0.02, 0, 0);
  peer_.facts.bodies[1].holder_count = 1;
  peer_.facts.bodies[1].holders[0] = 9;
  SnapshotPeer ben;
  ben.id = 9;
  ben.name = "ben";
  task_.OnPeers({ben});
  Run(1);
  task_.GoBack(RetraceRequest::To::kReset, now_ns_);
  const std::optional<HandTask::Ended> ended = Run(2000);
  ASSERT_TRUE(ended);
  EXPECT_FALSE(ended->ok);
  EXPECT_EQ(ended->reason, "1 body went back; bolt did not: ben holds it");
}

TEST_F(HandTaskTest, ResetNamesWhatIsInTheWayOfABodyAndGoesOnWithTheOthers) {
  peer_.follows = true;
  Run(1);
  peer_.facts.bodies[1].X_WB.p = Vec3(0, 0.02, 0);
  Run(1);
  peer_.facts.bodies[0].X_WB.p = Vec3(0.02, 0, 0);
  peer_.blocked = 0;
  peer_.blocked_at_x = 0.003;
  peer_.facts.contact_count = 2;
  peer_.facts.contacts[0] = {.force = 1, .other = -1};
  peer_.facts.contacts[1] = {.force = 9, .other = 2};
  Run(1);
  task_.GoBack(RetraceRequest::To::kReset, now_ns_);
  const std::optional<HandTask::Ended> ended = Run(10'000);
  ASSERT_TRUE(ended);
  EXPECT_FALSE(ended->ok);
  EXPECT_EQ(ended->reason, "1 body went back; peg did not: frame is in its way");
  EXPECT_NEAR(peer_.facts.bodies[0].X_WB.p.x(), 0.003, 1e-9) << "it stays there";
}

TEST_F(HandTaskTest, ResetTriesABlockedBodyAgainWhenAnotherHasArrived) {
  peer_.follows = true;
  Run(1);
  peer_.facts.bodies[1].X_WB.p = Vec3(0, 0.02, 0);
  Run(1);
  peer_.facts.bodies[0].X_WB.p = Vec3(0.02, 0, 0);
  Run(1);
  peer_.blocked = 0;
  peer_.blocked_at_x = 0.01;
  task_.GoBack(RetraceRequest::To::kReset, now_ns_);
  std::optional<HandTask::Ended> ended;
  for (int i = 0; i < 10'000 && !ended; ++i) {
    ended = Run(1);
    // the bolt was in the peg's way
    if (peer_.facts.bodies[1].X_WB.p.norm() < 1e-6) peer_.blocked = -1;
  }
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->reason, "2 bodies went back");
}

TEST_F(HandTaskTest, ResetGoesOnWhenABodyIsRefused) {
  peer_.follows = true;
  Run(1);
  peer_.facts.bodies[0].X_WB.p = Vec3(0.02, 0, 0);
  Run(1);
  peer_.deaf = true;
  task_.GoBack(RetraceRequest::To::kReset, now_ns_);
  EXPECT_FALSE(Run(10));
  task_.OnNews({Notification::Kind::kRefused, 1, 9}, "ben holds peg", scene_);
  const std::optional<HandTask::Ended> ended = Run(10);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->reason, "0 bodies went back; peg did not: ben holds peg");
}

TEST_F(HandTaskTest, GoalCancelsTheWayBack) {
  TakePeg();
  task_.GoBack(RetraceRequest::To::kGrasp, now_ns_);
  Run(10);
  task_.SetGoal(GoalOrder::Input::kPose, Pose(), Vec3::Zero(), Vec3::Zero());
  const std::optional<HandTask::Ended> ended = task_.TakeEnded();
  ASSERT_TRUE(ended);
  EXPECT_FALSE(ended->ok);
  EXPECT_FALSE(task_.busy());
}

TEST_F(HandTaskTest, LaterOrderReplacesAnEarlierOne) {
  peer_.deaf = true;
  task_.Take(0, {.body = "peg"}, scene_, now_ns_);
  Run(5);
  task_.Take(1, {.body = "bolt"}, scene_, now_ns_);
  const std::optional<HandTask::Ended> ended = task_.TakeEnded();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->reason, "another request for the hand has replaced this one");
}

TEST_F(HandTaskTest, UnansweredGrabEndsAfterSevenSeconds) {
  peer_.deaf = true;
  task_.Take(0, {.body = "peg"}, scene_, now_ns_);
  EXPECT_FALSE(Run(6900));
  const std::optional<HandTask::Ended> ended = Run(200);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->reason, "no peer has granted peg");
}

TEST_F(HandTaskTest, RequestNotifiesTheHolder) {
  peer_.deaf = true;
  task_.AskFor(0, scene_, now_ns_);
  Run(5);
  task_.OnNews({Notification::Kind::kRefused, 1, 9},
               "ben holds peg, and its user sees that you ask for it", scene_);
  const std::optional<HandTask::Ended> ended = task_.TakeEnded();
  ASSERT_TRUE(ended);
  EXPECT_TRUE(ended->ok);
}

}  // namespace
}  // namespace tandem
