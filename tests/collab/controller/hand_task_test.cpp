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

TEST_F(HandTaskTest, ResetRunsToTheStartOfThePath) {
  TakePeg();
  task_.GoBack(RetraceRequest::To::kReset, now_ns_);
  Run(10);
  peer_.facts.way = PathBacktracker::State::kArrived;
  const std::optional<HandTask::Ended> ended = Run(20);
  ASSERT_TRUE(ended);
  EXPECT_TRUE(ended->ok);
  EXPECT_EQ(ended->reason, "1 body went back");
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
