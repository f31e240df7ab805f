// Tests taking, letting go and handing over by whole peers on the simulated network.
#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

constexpr ObjectId kBox = 0;  // held by 1 at first
constexpr ObjectId kOtherBody = 1;

std::shared_ptr<const WorldModel> TwoBoxes() {
  const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
  return testing::MakeWorldModel({{box}, {Transformed(box, {Quat::Identity(), Vec3(0.3, 0, 0)})}},
                                 0.001);
}

class Holding : public ::testing::Test {
 protected:
  /// Adds a peer whose hand carries what it has by `by` within a second.
  std::size_t Add(PeerId id, int object, const Vec3& by) {
    NodeOptions options;
    options.peer.id = id;
    options.peer.held_object = object;
    options.name = "peer " + std::to_string(id);
    options.conditions.delay_ms = delay_ms_;
    HandScript script;
    script.waypoints = {{0, Vec3::Zero(), Quat::Identity()}, {1, by, Quat::Identity()}};
    auto device = std::make_unique<ScriptedDevice>(script, model_->bodies[0].X_WB0);
    return session_.Add(std::make_unique<PeerNode>(model_, std::move(device), 42, options), id);
  }
  void Run(int frames) {
    for (int i = 0; i < frames; ++i) session_.Step();
  }
  void Order(std::size_t peer, Command::Kind kind, ObjectId object = kNoObject, PeerId to = 0) {
    ASSERT_TRUE(session_.node(peer).peer().commands().TryPush({kind, object, to}));
  }
  int Held(std::size_t peer) { return session_.node(peer).peer().ownership().held(); }
  PeerId Authority(std::size_t at) { return session_.node(at).peer().ownership().authority(kBox); }
  Vec3 Place(std::size_t at, std::size_t body = kBox) {
    return session_.node(at).world().state(body).X_WB.p;
  }

  std::shared_ptr<const WorldModel> model_ = TwoBoxes();
  SimulatedSession session_;
  double delay_ms_ = 20;  // delay of states
};

TEST_F(Holding, ReleasedBodyStaysInPlaceForAllPeers) {
  Add(1, kBox, Vec3(0.1, 0, 0));
  Add(2, -1, Vec3::Zero());
  Run(2000);
  EXPECT_NEAR(Place(0).x(), 0.1, 1e-3);
  EXPECT_LT((Place(1) - Place(0)).norm(), 1e-3);
  Order(0, Command::Kind::kRelease);
  Run(500);
  const Vec3 put_down = Place(0);
  EXPECT_EQ(Held(0), -1);
  EXPECT_LT((Place(1) - put_down).norm(), 1e-6);
  Add(3, -1, Vec3::Zero());
  Run(1500);  // 0.1 m by its share of the travel limit a frame
  EXPECT_LT((Place(2) - put_down).norm(), 1e-6);
  EXPECT_EQ(Place(0), put_down);
}

TEST_F(Holding, GrabGivesNoForce) {
  Add(1, kBox, Vec3(0.1, 0, 0));
  Add(2, -1, Vec3::Zero());
  Run(2000);
  Order(0, Command::Kind::kRelease);
  Run(500);
  const Vec3 before = Place(0);
  Order(1, Command::Kind::kGrab, kBox);
  double largest = 0;
  for (int i = 0; i < 1000; ++i) {
    session_.Step();
    largest = std::max(largest, session_.node(1).peer().report().hand_B_W.f.norm());
  }
  EXPECT_EQ(Held(1), 0);
  EXPECT_EQ(Authority(0), 2U);
  EXPECT_EQ(Authority(1), 2U);
  EXPECT_LT(largest, 0.01) << "the hand takes it where it is";
  EXPECT_LT((Place(0) - before).norm(), 1e-3);
}

TEST_F(Holding, HandoverHasOneHolderInEveryFrame) {
  Add(1, kBox, Vec3(0.1, 0, 0));
  Add(2, -1, Vec3::Zero());
  Run(1500);
  Order(0, Command::Kind::kGive, kBox, 2);
  for (int i = 0; i < 500; ++i) {
    session_.Step();
    EXPECT_LE((Held(0) == 0) + (Held(1) == 0), 1);
  }
  EXPECT_EQ(Held(0), -1);
  EXPECT_EQ(Held(1), 0);
  EXPECT_LT((Place(1) - Vec3(0.1, 0, 0)).norm(), 2e-3);
}

// A body is given while it moves, on a slow line: where it is now is known before its picture is
// there.
TEST_F(Holding, DistantGrabbedBodyArrivesAtHandSpeedAndAtRest) {
  delay_ms_ = 300;
  Add(1, kBox, Vec3(0.2, 0, 0));
  Add(2, -1, Vec3::Zero());
  Run(520);
  const Vec3 given = Place(0);
  Vec3 last = Place(1);
  ASSERT_GT((given - last).norm(), 0.05);
  Order(0, Command::Kind::kGive, kBox, 2);
  double largest = 0;
  for (int i = 0; i < 1000; ++i) {
    session_.Step();
    const bool held = session_.node(1).peer().held_state() != nullptr;
    ASSERT_TRUE(!held || (Place(1) - last).norm() < 1.1e-3) << i;
    last = Place(1);
    largest = std::max(largest, session_.node(1).peer().report().hand_B_W.f.norm());
  }
  EXPECT_EQ(Held(1), 0);
  EXPECT_LT((Place(1) - given).norm(), 3e-3);
  EXPECT_LT(largest, 0.05) << "N, in a hand that rests";
}

TEST_F(Holding, HeldBodyCannotBeTaken) {
  Add(1, kBox, Vec3(0.1, 0, 0));
  Add(2, kOtherBody, Vec3::Zero());
  Run(500);
  EXPECT_EQ(Held(0), 0);
  EXPECT_EQ(Held(1), 1);
  session_.node(1).TakeNotifications();
  Order(1, Command::Kind::kGrab, kBox);
  Run(100);
  EXPECT_EQ(Held(0), 0);
  EXPECT_EQ(Held(1), -1);
  const std::vector<std::string> notification = session_.node(1).TakeNotifications();
  ASSERT_EQ(notification.size(), 3U);
  EXPECT_EQ(notification[2].rfind("peer 1 holds ", 0), 0U) << notification[2];
}

TEST_F(Holding, BodyOfACrashedHolderStopsAndCanBeTaken) {
  Add(1, kBox, Vec3(0.1, 0, 0));
  Add(2, -1, Vec3::Zero());
  Add(3, -1, Vec3::Zero());
  Run(2000);
  session_.Kill(0);
  Run(1000);  // the lease, and 0.3 s
  EXPECT_EQ(Authority(1), 2U);
  EXPECT_EQ(Authority(2), 2U);
  EXPECT_LT((Place(2) - Place(1)).norm(), 1e-6);
  EXPECT_NEAR(Place(1).x(), 0.1, 2e-3);
  Order(2, Command::Kind::kGrab, kBox);
  Run(100);
  EXPECT_EQ(Held(2), 0);
  EXPECT_EQ(Authority(1), 3U);
}

TEST_F(Holding, LeavingPeerPassesOnItsOwnership) {
  Add(1, kBox, Vec3(0.1, 0, 0));
  Add(2, -1, Vec3::Zero());
  Add(3, -1, Vec3::Zero());
  Run(1200);
  const Vec3 last = Place(0);
  session_.Leave(0);
  Run(300);
  EXPECT_EQ(Authority(1), 2U);
  EXPECT_EQ(Authority(2), 2U);
  EXPECT_LT((Place(1) - last).norm(), 1e-6) << "where it was, not where it was heard of last";
  EXPECT_LT((Place(2) - last).norm(), 1e-6);
}

}  // namespace
}  // namespace tandem
