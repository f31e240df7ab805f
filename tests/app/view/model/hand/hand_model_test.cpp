#include "app/view/model/hand/hand_model.h"

#include <gtest/gtest.h>

#include "app/view/model/hand/hand_keys.h"
#include "tests/app/view/fake_session.h"
#include "tests/app/view/model/hand/fake_controller.h"

namespace tandem {
namespace {

constexpr std::size_t kBallInHand = 1;
const Vec3 kGrabbedAt{0.01, -0.13, 0.0};

class Hand : public ::testing::Test {
 protected:
  void Begin() {
    HandRequest request;
    request.scene = "block_and_ball.json";
    request.name = "anna";
    request.control = "test";
    hand_.Start(request);
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return hand_.ready();
    }));
  }
  void Take() {
    hand_.Grab(kBallInHand, kGrabbedAt);
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return hand_.held() == kBallInHand;
    }));
  }

  FakeController controller_;
  HandModel hand_{controller_.Attach(), controller_.Launch()};
};

TEST_F(Hand, StartsAControllerAndAttachesToIt) {
  Begin();
  ASSERT_EQ(controller_.launched.size(), 1U);
  EXPECT_EQ(controller_.launched[0].scene, "block_and_ball.json");
  EXPECT_EQ(controller_.processes, 1);
  EXPECT_FALSE(hand_.held().has_value());
}

TEST_F(Hand, GrabsABodyAndMovesItsGoal) {
  Begin();
  Take();
  const auto grabs = controller_.Asked<GrabRequest>();
  ASSERT_EQ(grabs.size(), 1U);
  EXPECT_EQ(grabs[0].body, "ball");
  EXPECT_EQ(grabs[0].grasp_W, (std::array<double, 3>{0.01, -0.13, 0.0}));
  const Pose goal{RotationBy({0, 0, 0.1}), kGrabbedAt + Vec3(0.02, 0, 0)};
  hand_.SetGoal(goal);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.snapshot().hand.X_WG.p_W[0] > 0.029;
  }));
  EXPECT_LT((ToPose(hand_.snapshot().hand.goal).p - goal.p).norm(), 1e-12);
}

TEST_F(Hand, ReportsWhyAGrabIsRefusedAndDropsTheGoal) {
  controller_.refuse = "ben holds it";
  Begin();
  hand_.Grab(kBallInHand, kGrabbedAt);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return !hand_.word().isEmpty();
  }));
  EXPECT_TRUE(hand_.word().contains("ball"));
  EXPECT_TRUE(hand_.word().contains("ben holds it"));
  EXPECT_FALSE(hand_.held().has_value());
}

TEST_F(Hand, RefusalNamesTheRequest) {
  Begin();
  Take();
  hand_.Give("ben");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.word().contains("nobody of that name");
  }));
  EXPECT_TRUE(hand_.word().contains("ben"));
}

TEST_F(Hand, ReportsASilentControllerAndReconnects) {
  Begin();
  controller_.received = false;
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.state() == HandModel::State::kLost;
  }));
  EXPECT_TRUE(hand_.trouble().contains("does not answer"));
  EXPECT_TRUE(hand_.shows());  // state as it was last
  hand_.Grab(kBallInHand, kGrabbedAt);
  EXPECT_TRUE(controller_.requested.empty());
  controller_.received = true;
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.ready();
  }));
}

TEST_F(Hand, ReportsTheControllersLastMessage) {
  controller_.reachable = false;
  HandRequest request;
  request.control = "test";
  hand_.Start(request);
  controller_.ended = "the controller ended with code 3: no such scene";
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.state() == HandModel::State::kEnded;
  }));
  EXPECT_TRUE(hand_.trouble().contains("no such scene"));
  EXPECT_EQ(controller_.processes, 0);
  controller_.ended.clear();
  controller_.reachable = true;
  Begin();  // and another one can be started
}

// The controller dies while its hand holds the ball. A new one takes its place by one request.
TEST_F(Hand, DeadControllersHandIsGoneAndStartsAgain) {
  Begin();
  Take();
  hand_.SetGoal({Quat::Identity(), kGrabbedAt + Vec3(0.02, 0, 0)});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.snapshot().hand.X_WG.p_W[0] > 0.029;
  }));
  const PlainPose where = hand_.snapshot().bodies[kBallInHand].X_W;
  EXPECT_FALSE(hand_.can_start_again());
  controller_.ended = "the program behind your hand was killed";
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.state() == HandModel::State::kEnded;
  }));
  EXPECT_FALSE(hand_.held().has_value());
  EXPECT_FALSE(HandPictureOf(hand_.snapshot(), hand_.goal()).tether.has_value());
  const ViewerPicture picture = PictureOf(hand_.snapshot(), "anna", hand_.alive());
  ASSERT_EQ(picture.peers.size(), 1U);
  EXPECT_EQ(picture.peers[0].presence, ViewedPeer::Presence::kLost);
  for (const ViewBody& body : picture.peers[0].bodies) EXPECT_EQ(body.flags & ViewBody::kHeld, 0U);
  // the part stays where it was
  EXPECT_TRUE(hand_.shows());
  EXPECT_EQ(hand_.snapshot().bodies[kBallInHand].X_W.p_W, where.p_W);

  controller_.ended.clear();
  ASSERT_TRUE(hand_.can_start_again());
  hand_.StartAgain();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.ready();
  }));
  ASSERT_EQ(controller_.launched.size(), 2U);
  EXPECT_EQ(controller_.launched[1].scene, controller_.launched[0].scene);
  EXPECT_EQ(controller_.processes, 1);
}

TEST_F(Hand, SilentControllersHandIsNotShown) {
  Begin();
  Take();
  controller_.received = false;
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.state() == HandModel::State::kLost;
  }));
  EXPECT_FALSE(hand_.held().has_value());
  EXPECT_FALSE(hand_.alive());
  controller_.received = true;
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.ready() && hand_.held().has_value();
  }));
}

TEST_F(Hand, KnowsWhoAsksForThePartInHandAndHandsItOver) {
  SnapshotPeer ben;
  ben.id = 0xbe;
  ben.name = "ben";
  controller_.now.peers = {ben};
  Begin();
  Take();
  const auto ask = [&] {
    controller_.now.asked = {ben.id, kBallInHand};
    controller_.now.news = "ben asks for ball, which you hold";
    ++controller_.now.news_count;
    return ProcessEventsUntil([&] {
      return hand_.asked().has_value();
    });
  };
  ASSERT_TRUE(ask());
  EXPECT_EQ(hand_.asked()->name, "ben");
  hand_.KeepPart();
  EXPECT_FALSE(hand_.asked().has_value());
  ASSERT_TRUE(ask());
  hand_.HandOverAsked();
  const auto gives = controller_.Asked<GiveRequest>();
  ASSERT_EQ(gives.size(), 1U);
  EXPECT_EQ(gives[0].peer, "00000000000000be");
  EXPECT_FALSE(hand_.asked().has_value());
}

TEST_F(Hand, StopIsToldOnce) {
  Begin();
  hand_.Stop();
  controller_.now.news = "emergency stop: the hand lets go and takes no body until it is resumed";
  ++controller_.now.news_count;
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.stopped();
  }));
  EXPECT_EQ(hand_.word(), QString());
}

TEST_F(Hand, TellsTheVerdictsOfASessionThatHasEnded) {
  QStringList told;
  QObject::connect(&hand_, &HandModel::SessionEnded, &hand_, [&](const QStringList& lines) {
    told = lines;
  });
  Begin();
  controller_.last_words = {"the host 'tandem-view' ends the controller",
                            "peg stands 60.0 mm from its first place and is NOT out"};
  hand_.Leave();
  EXPECT_EQ(told, QStringList{"peg stands 60.0 mm from its first place and is NOT out"});
}

TEST_F(Hand, TellsNothingOfASessionInWhichItHeldNothing) {
  QStringList told;
  QObject::connect(&hand_, &HandModel::SessionEnded, &hand_, [&](const QStringList& lines) {
    told = lines;
  });
  Begin();
  controller_.last_words = {"the host 'tandem-view' ends the controller"};
  hand_.Leave();
  EXPECT_EQ(told, QStringList());
}

TEST_F(Hand, EndsOnlyItsOwnController) {
  Begin();
  hand_.Leave();
  EXPECT_EQ(controller_.Asked<QuitRequest>().size(), 1U);
  EXPECT_EQ(controller_.processes, 0);
  EXPECT_EQ(hand_.state(), HandModel::State::kNone);
  hand_.TakeUp("of somebody else", "anna");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.ready();
  }));
  hand_.Leave();
  EXPECT_EQ(controller_.Asked<QuitRequest>().size(), 1U);
}

TEST_F(Hand, ReleasesStopsAndResumes) {
  Begin();
  Take();
  hand_.Stop();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.stopped();
  }));
  EXPECT_FALSE(hand_.held().has_value());
  hand_.Resume();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return !hand_.stopped();
  }));
  Take();
  hand_.Release();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return !hand_.held().has_value();
  }));
}

TEST(HandPicture, ShowsOtherPeersInstancesAsGhosts) {
  ControllerSnapshot now;
  now.self = 7;
  now.bodies.resize(3);
  now.bodies[0].shared = true;
  now.bodies[0].in_hand = true;
  now.bodies[0].holders = {7, 9};
  now.bodies[1].holders = {9};
  now.bodies[2].fixed = true;
  SnapshotPeer ben;
  ben.id = 9;
  ben.name = "ben";
  ben.delay_s = 0.1;
  now.peers = {ben};
  SnapshotInstance instance;
  instance.peer = 9;
  instance.X_W.p_W = {0.01, 0, 0};
  now.instances = {instance};
  const ViewerPicture picture = PictureOf(now, "anna");
  ASSERT_EQ(picture.peers.size(), 2U);
  EXPECT_EQ(picture.peers[0].info.name, "anna");
  ASSERT_EQ(picture.peers[0].bodies.size(), 1U);  // neither ben's own nor the fixed one
  EXPECT_EQ(picture.peers[1].bodies.size(), 2U);
  EXPECT_DOUBLE_EQ(picture.peers[1].delay_ms, 100);

  const std::vector<BodyLook> exact_queries{{}, {}, {.fixed = true}};
  PictureComposer composer;
  DrawList list = composer.Compose(picture, exact_queries, 0);
  ASSERT_EQ(list.ghosts.size(), 1U);
  EXPECT_DOUBLE_EQ(list.ghosts[0].X_W.p.x(), 0.01);
}

TEST(HandPicture, NamesTheHolderOfAPart) {
  ControllerSnapshot now;
  now.self = 7;
  now.bodies.resize(2);
  now.bodies[0].shared = now.bodies[1].shared = true;
  now.bodies[0].holders = {9};  // ben, alone; ours is his mirror
  SnapshotPeer ben;
  ben.id = 9;
  ben.name = "ben";
  now.peers = {ben};
  const std::vector<BodyLook> exact_queries{{}, {}};
  PictureComposer composer;
  DrawList list = composer.Compose(PictureOf(now, "anna"), exact_queries, 0);
  EXPECT_EQ(list.solids.size(), 2U);
  EXPECT_TRUE(list.ghosts.empty());
  ASSERT_EQ(list.labels.size(), 1U);
  EXPECT_EQ(list.labels[0].text, "ben");
  EXPECT_EQ(list.labels[0].body, 0U);
}

TEST(HandPicture, GoalIsATetheredGhostOfThePart) {
  ControllerSnapshot now;
  now.self = 7;
  now.bodies.resize(1);
  now.bodies[0].in_hand = true;
  now.bodies[0].X_W.p_W = {0.5, 0, 0};
  now.hand.body = 0;
  now.hand.X_WG.p_W = {0.6, 0, 0};
  now.hand.force_N = {0, 0, 3};
  const Pose goal{RotationBy({0, 0, 0.2}), Vec3(0.6, 0.1, 0)};
  const std::vector<BodyLook> exact_queries{{}};
  DrawList list;
  AddGoal(now, goal, exact_queries, list);
  ASSERT_EQ(list.ghosts.size(), 1U);
  // the body's point at the grasp is at the goal: it stands 10 cm behind it along the turned axis
  const Vec3 expected = goal.p + goal.q * Vec3(-0.1, 0, 0);
  EXPECT_LT((list.ghosts[0].X_W.p - expected).norm(), 1e-12);
  const HandPicture picture = HandPictureOf(now, goal);
  ASSERT_TRUE(picture.tether.has_value());
  EXPECT_DOUBLE_EQ(picture.tether->force_N, 3);
  EXPECT_EQ(picture.tether->from_W, Vec3(0.6, 0, 0));
  // a goal at the part itself shows no ghost
  list = {};
  AddGoal(now, ToPose(now.hand.X_WG), exact_queries, list);
  EXPECT_TRUE(list.ghosts.empty());
}

TEST(HandPicture, ForceGoesFromGreenToRed) {
  EXPECT_GT(ForceColour(0)[1], ForceColour(0)[0]);
  EXPECT_GT(ForceColour(kTetherFullForce)[0], 5 * ForceColour(kTetherFullForce)[1]);
  EXPECT_EQ(ForceColour(1e9), ForceColour(kTetherFullForce));
}

TEST(HandKeys, ArrowsMoveCtrlTurnsAndAxesLock) {
  using Kind = HandKey::Kind;
  EXPECT_EQ(HandKeyOf(Qt::Key_Right, {})->steps_C, Vec3(1, 0, 0));
  EXPECT_EQ(HandKeyOf(Qt::Key_PageUp, {})->steps_C, Vec3(0, 0, -1));
  EXPECT_EQ(HandKeyOf(Qt::Key_Up, Qt::ShiftModifier)->steps_C, Vec3(0, 0.1, 0));
  const auto turn = HandKeyOf(Qt::Key_Right, Qt::ControlModifier);
  EXPECT_EQ(turn->kind, Kind::kTurn);
  EXPECT_EQ(turn->steps_C, Vec3(0, 1, 0));  // about the picture's up: the near side goes right
  EXPECT_EQ(HandKeyOf(Qt::Key_Y, {})->axis, 1);
  EXPECT_EQ(HandKeyOf(Qt::Key_Y, {})->kind, Kind::kLock);
  EXPECT_TRUE(HandKeyOf(Qt::Key_Z, Qt::ShiftModifier)->plane);
  EXPECT_FALSE(HandKeyOf(Qt::Key_Z, Qt::ControlModifier).has_value());  // undo
  EXPECT_FALSE(HandKeyOf(Qt::Key_Q, {}).has_value());
}

}  // namespace
}  // namespace tandem
