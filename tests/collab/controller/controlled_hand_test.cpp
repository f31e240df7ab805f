#include <gtest/gtest.h>

#include "collab/controller/control_server.h"
#include "collab/controller/fill_facts.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

// Runs a whole peer whose hand a host moves, frame by frame in virtual time: a block of 40 mm over
// a table, and a wall at its side.

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::kVoxel;

constexpr std::int64_t kFrameNs = 1'000'000;
constexpr HostId kHost = 5;
constexpr double kWallX = 0.1;  // the wall's face
constexpr double kHalf = 0.02;  // half an edge of the block

std::shared_ptr<const WorldModel> BlockAndWall() {
  auto model = testing::MakeWorldModel(
      {{.mesh_W = At(Box({0.02, 0.3, 0.3}), {kWallX + 0.01, 0, 0}), .fixed = true},
       {.mesh_W = At(Box({2 * kHalf, 2 * kHalf, 2 * kHalf}), Vec3::Zero()), .mass = 0.5}},
      kVoxel);
  return model;
}

class ControlledHandTest : public ::testing::Test, private ControlledPeer {
 protected:
  ControlledHandTest() {
    kHapticThread.Enter();
    kControlThread.Enter();
    model_ = BlockAndWall();
    auto device = std::make_unique<GoalDevice>(goals_);
    device_ = device.get();
    NodeOptions options;
    options.peer.id = 3;
    node_ = std::make_unique<PeerNode>(model_, std::move(device), 42, options);
    ControlScene scene = ControlSceneOf(*model_);
    scene.bodies[1].name = "block";
    server_.OnScene(scene, now_ns_);
  }

  void Frame() {
    now_ns_ += kFrameNs;
    device_->See(SeePart(*node_, *device_));
    node_->HapticFrame(now_ns_);
    FillFacts(*node_, device_, ++frame_, now_ns_, facts_);
    server_.OnGoal(kHost, {}, now_ns_);
    node_->TakeNotifications([this](const Notification& news, const std::string& line) {
      server_.OnNews(news, line);
    });
    server_.OnFacts(facts_, now_ns_);
    server_.Tick(now_ns_);
    const double force = facts_.hand_G_W.f.norm();
    peak_force_ = std::max(peak_force_, force);
    farthest_ = std::max(farthest_, Block().p.x());
    const double step = (Block().p - last_p_).norm();
    peak_step_ = std::max(peak_step_, step);
    last_p_ = Block().p;
  }
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) Frame();
  }
  Answer Ask(const ControlRequest& request, int ms = 20'000) {
    server_.OnRequest(kHost, "test", ++number_, request, now_ns_);
    for (int i = 0; i < ms; ++i) {
      Frame();
      for (const HostAnswer& answer : server_.TakeAnswers()) {
        if (answer.number == number_) return answer.answer;
      }
    }
    return {false, "no answer"};
  }
  /// Moves the host's goal there in one step.
  void Mean(const Vec3& p_WG) {
    HostGoal goal{.kind = HostGoal::Kind::kPose, .seq = ++goal_seq_};
    goal.X_WG.p = p_WG;
    server_.OnGoal(kHost, goal, now_ns_);
  }
  const Pose& Block() const { return node_->world().state(0).X_WB; }

  bool Order(const Command& command) override { return node_->peer().commands().TryPush(command); }
  void Tell(const GoalOrder& order) override {
    goals_->newest.back() = order;
    goals_->newest.Publish();
  }
  void Begin(std::uint64_t, const ControlRequest&) override {}
  void StopDevice(bool) override {}
  bool ChangeWorkspace(const WorkspaceChange&) override { return false; }
  void Quit() override {}

  std::int64_t now_ns_ = 0;
  std::uint64_t frame_ = 0;
  std::uint64_t number_ = 0;
  std::uint32_t goal_seq_ = 0;
  std::shared_ptr<GoalDevice::Orders> goals_ = std::make_shared<GoalDevice::Orders>();
  std::shared_ptr<const WorldModel> model_;
  GoalDevice* device_ = nullptr;
  std::unique_ptr<PeerNode> node_;
  ControlServer server_{*this, false};
  SimulationFacts facts_;
  double peak_force_ = 0;
  double farthest_ = -1;
  double peak_step_ = 0;
  Vec3 last_p_ = Vec3::Zero();
};

TEST_F(ControlledHandTest, GraspedPointReachesTheGoal) {
  const Vec3 corner(kHalf, kHalf, kHalf);
  ASSERT_TRUE(Ask(GrabRequest{.body = "block", .grasp_W = {{kHalf, kHalf, kHalf}}}).ok);
  EXPECT_LT(peak_step_, 1e-6) << "taking it moves nothing";
  Mean(corner + Vec3(0, 0.05, 0));
  Run(1500);
  EXPECT_NEAR(Block().p.y(), 0.05, 2e-4);
  EXPECT_LT(Block().q.angularDistance(Quat::Identity()), 1e-3);
}

TEST_F(ControlledHandTest, GoalBehindAWallIsForceLimitedAndBlocked) {
  ASSERT_TRUE(Ask(SetParameterRequest{"hand_force_N", 6}).ok);
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  Mean({0.5, 0, 0});
  Run(3000);
  // at rest against the wall the spring pulls with what is allowed, whatever the goal
  EXPECT_NEAR(facts_.hand_G_W.f.x(), 6.0, 0.05);
  EXPECT_GT(facts_.contact_count, 0U);
  // on the way its damper pulls too, by at most 8 N s/m times the goal's speed of 1 m/s, and the
  // calming force, by at most the limit once more
  EXPECT_LT(peak_force_, 6.0 + 8.0 + 6.0);
  EXPECT_LT(farthest_, kWallX - kHalf + 0.5 * kVoxel);
  const ControllerSnapshot snapshot = server_.Snapshot();
  EXPECT_EQ(snapshot.hand.goal.p_W[0], 0.5);
  EXPECT_NEAR(snapshot.hand.limited_goal.p_W[0] - snapshot.hand.X_WG.p_W[0], 6.0 / 800, 1e-4);
}

TEST_F(ControlledHandTest, FreedPartDoesNotLeapToItsGoal) {
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  Mean({0.5, 0, 0});
  Run(2000);
  peak_step_ = 0;
  Mean({-0.2, 0, 0});
  Run(2000);
  EXPECT_NEAR(Block().p.x(), -0.2, 1e-3);
  // the goal goes 1 m/s; a part of 0.5 kg on 800 N/m that it draws along swings a little beyond
  EXPECT_LT(peak_step_, 1.5e-3);
}

TEST_F(ControlledHandTest, RateMovesTheGoalAndExpires) {
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  HostGoal rate{.kind = HostGoal::Kind::kRate, .seq = ++goal_seq_};
  rate.linear = Vec3(0, 0.1, 0);
  server_.OnGoal(kHost, rate, now_ns_);
  Run(1000);
  // 0.1 m/s for the 200 frames that a rate lasts, 199 or 200 of them with the goal's order
  EXPECT_NEAR(Block().p.y(), 0.02, 2e-4);
}

TEST_F(ControlledHandTest, PushMovesAtAProportionalRateAndStopsAtContact) {
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  for (int i = 0; i < 3000; ++i) {
    HostGoal push{.kind = HostGoal::Kind::kPush, .seq = ++goal_seq_};
    push.linear = Vec3(5, 0, 0);  // 0.1 m/s
    server_.OnGoal(kHost, push, now_ns_);
    Frame();
  }
  EXPECT_LT(farthest_, kWallX - kHalf + 0.5 * kVoxel);
  EXPECT_NEAR(facts_.hand_G_W.f.x(), 10.0, 0.1) << "the limit, not more with time";
  // it turns back at once: nothing has wound up
  for (int i = 0; i < 500; ++i) {
    HostGoal push{.kind = HostGoal::Kind::kPush, .seq = ++goal_seq_};
    push.linear = Vec3(-5, 0, 0);
    server_.OnGoal(kHost, push, now_ns_);
    Frame();
  }
  // 0.5 s at 0.1 m/s, less the 12.5 mm that the goal was ahead
  EXPECT_NEAR(Block().p.x(), kWallX - kHalf - 0.05 + 0.0125, 0.005);
}

TEST_F(ControlledHandTest, ReturnsAlongItsPathRoundACorner) {
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  Mean({0, 0.3, 0});
  Run(1500);
  Mean({0.2, 0.3, 0});  // past the wall's end at y = 0.15
  Run(1500);
  Mean({0.2, 0, 0});  // behind it
  Run(1500);
  ASSERT_NEAR(Block().p.x(), 0.2, 2e-3);
  ASSERT_NEAR(Block().p.y(), 0.0, 2e-3);
  peak_step_ = 0;
  const Answer answer = Ask(RetraceRequest{RetraceRequest::To::kGrasp});
  EXPECT_TRUE(answer.ok) << answer.reason;
  EXPECT_LT(Block().p.norm(), 3e-3);
  EXPECT_LT(peak_step_, 0.5e-3) << "0.25 m/s, and what a spring adds";
  EXPECT_EQ(facts_.held, 0);
}

TEST_F(ControlledHandTest, ResetLeadsAPartHomeRoundTheCornerThatItCameBy) {
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  for (const Vec3& goal : {Vec3(0, 0.3, 0), Vec3(0.2, 0.3, 0), Vec3(0.2, 0, 0)}) {
    Mean(goal);
    Run(1500);
  }
  ASSERT_TRUE(Ask(ReleaseRequest{}).ok);
  ASSERT_NEAR(Block().p.x(), 0.2, 2e-3) << "behind the wall";
  peak_step_ = 0;
  const Answer answer = Ask(RetraceRequest{RetraceRequest::To::kReset});
  EXPECT_EQ(answer.reason, "1 body went back");
  EXPECT_LT(Block().p.norm(), PathBacktracker::kThere + 1e-3);
  EXPECT_LT(peak_step_, 0.5e-3) << "0.25 m/s, and what a spring adds";
  EXPECT_EQ(facts_.held, -1);
}

TEST_F(ControlledHandTest, UndoReturnsAReleasedPart) {
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  Mean({0, 0.1, 0});
  Run(1000);
  ASSERT_TRUE(Ask(ReleaseRequest{}).ok);
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  Mean({0, 0.1, 0.1});
  Run(1000);
  ASSERT_TRUE(Ask(ReleaseRequest{}).ok);
  Answer answer = Ask(RetraceRequest{RetraceRequest::To::kUndo});
  ASSERT_TRUE(answer.ok) << answer.reason;
  EXPECT_LT((Block().p - Vec3(0, 0.1, 0)).norm(), 4e-3);
  EXPECT_EQ(facts_.held, -1);
  answer = Ask(RetraceRequest{RetraceRequest::To::kReset});
  ASSERT_TRUE(answer.ok) << answer.reason;
  EXPECT_LT(Block().p.norm(), 6e-3);
  EXPECT_EQ(Ask(RetraceRequest{RetraceRequest::To::kUndo}).reason, "there is nothing to undo");
}

TEST_F(ControlledHandTest, NonFiniteGoalMovesNothing) {
  ASSERT_TRUE(Ask(GrabRequest{.body = "block"}).ok);
  HostGoal goal{.kind = HostGoal::Kind::kPose, .seq = ++goal_seq_};
  goal.X_WG.p.x() = std::nan("");
  server_.OnGoal(kHost, goal, now_ns_);
  Run(100);
  EXPECT_LT(Block().p.norm(), 1e-6);
}

}  // namespace
}  // namespace tandem
