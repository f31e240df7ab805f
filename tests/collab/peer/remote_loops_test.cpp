// Tests type-1 contact by whole peers on the simulated network: which loops count for which body.
#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "tests/support/scripted_node.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::ScriptedNode;

/// Returns a cube for each of three peers: two side by side, the third half a metre away.
std::shared_ptr<const WorldModel> ThreeCubes() {
  const TriangleMesh cube = Box(Vec3(0.03, 0.03, 0.03));
  return testing::MakeWorldModel(
      {{At(cube, Vec3(-0.05, 0, 0))}, {At(cube, Vec3(0.05, 0, 0))}, {At(cube, Vec3(0, 0.5, 0))}},
      0.002);
}

/// Returns a way of 55 mm in a second from 6 s on, or as many times that.
std::vector<Waypoint> Inward(double times) {
  return {{0, Vec3::Zero(), Quat::Identity()},
          {6, Vec3::Zero(), Quat::Identity()},
          {7, Vec3(0.055 * times, 0, 0), Quat::Identity()}};
}

enum class Third { kNone, kHolds, kLetsGo };

/// Figures of the first user's press on the second one's cube at rest.
struct Press {
  Vec3 force = Vec3::Zero();
  double mirror_lag = 0;
  double apart = 0;  // distance of the true instances' centres
};

/// Lets two press over half a millisecond. The third is half a second from everybody.
Press QuickPress(Third third) {
  const auto model = ThreeCubes();
  SimulatedSession session;
  session.Add(ScriptedNode(model, 1, 0, Inward(1), 0.5), 1);
  session.Add(ScriptedNode(model, 2, 1, Inward(-1), 0.5), 2);
  if (third != Third::kNone) {
    session.Add(ScriptedNode(model, 3, 2, {}, 500), 3);
    for (const std::size_t user : {0U, 1U}) {
      session.node(user).inbox().Switch(3, {.delay_ms = 500});
    }
  }
  for (int i = 0; i < 16000; ++i) {
    if (i == 3000 && third == Third::kLetsGo) {
      session.node(2).peer().commands().TryPush({Command::Kind::kRelease, kNoObject, 0});
    }
    session.Step();
  }
  const Peer& peer = session.node(0).peer();
  return {peer.report().hand_B_W.f, peer.mirror_lag_m(),
          session.node(1).peer().held_state()->X_WB.p.x() - peer.held_state()->X_WB.p.x()};
}

TEST(RemoteLoops, SlowBystanderDoesNotAffectAFastPress) {
  const Press alone = QuickPress(Third::kNone);
  EXPECT_GT(alone.force.norm(), 4.0);
  EXPECT_GT(alone.apart, 0.03);
  for (const Third third : {Third::kHolds, Third::kLetsGo}) {
    const Press press = QuickPress(third);
    EXPECT_LT((press.force - alone.force).norm(), 1e-6) << static_cast<int>(third);
    EXPECT_NEAR(press.mirror_lag, alone.mirror_lag, 1e-9) << static_cast<int>(third);
    EXPECT_NEAR(press.apart, alone.apart, 1e-9) << static_cast<int>(third);
  }
}

// One peer presses, the other lets go of what is pressed. Nobody moves the body any more, so it
// stands where it was put, and comes there at a pace that jolts no hand.
TEST(RemoteLoops, BodyReleasedUnderPressureIsRigid) {
  const auto model = ThreeCubes();
  SimulatedSession session;
  session.Add(ScriptedNode(model, 1, 0, Inward(1), 20), 1);
  session.Add(ScriptedNode(model, 2, 1, Inward(-1), 20), 2);
  const Peer& peer = session.node(0).peer();
  const World& world = session.node(0).world();
  for (int i = 0; i < 9000; ++i) session.Step();
  EXPECT_GT(peer.mirror_lag_m(), 0.005);
  session.node(1).peer().commands().TryPush({Command::Kind::kRelease, kNoObject, 0});
  Vec3 last = peer.report().hand_B_W.f;
  double largest_step = 0;
  for (int i = 0; i < 3000; ++i) {
    session.Step();
    largest_step = std::max(largest_step, (peer.report().hand_B_W.f - last).norm());
    last = peer.report().hand_B_W.f;
    ASSERT_GT(world.state(1).X_WB.p.x() - world.state(0).X_WB.p.x(), 0.029) << i;
  }
  const Vec3 put = session.node(1).world().state(1).X_WB.p;
  EXPECT_LT((world.state(1).X_WB.p - put).norm(), 1e-4);
  EXPECT_GT(peer.report().pushing_points, 0);  // it is pressed all the time
  EXPECT_GT(last.norm(), 4.0);
  EXPECT_LE(largest_step, 0.5);  // N a frame
}

// A body in two hands is met as one: the slower of the two loops says how far it gives way.
TEST(RemoteLoops, SharedBodysComplianceFollowsItsSlowestHolder) {
  auto model = std::make_shared<WorldModel>(*ThreeCubes());
  model->scene.bodies[1].shared = true;
  const auto force = [&](double delay_ms) {
    SimulatedSession session;
    session.Add(ScriptedNode(model, 1, 0, Inward(2), 2), 1);
    session.Add(ScriptedNode(model, 2, 1, {}, 2), 2);
    session.Add(ScriptedNode(model, 3, 1, {}, delay_ms), 3);
    session.node(0).inbox().Switch(3, {.delay_ms = delay_ms});
    for (int i = 0; i < 12000; ++i) session.Step();
    return session.node(0).peer().report().hand_B_W.f.norm();
  };
  EXPECT_LT(force(400), 0.6 * force(2));
}

// A peer that lets go has no loop with us any more, nor have we one with it. It is there again with
// the next grasp.
TEST(RemoteLoops, LoopEndsWithTheHold) {
  const auto model = ThreeCubes();
  SimulatedSession session;
  session.Add(ScriptedNode(model, 1, 0, {}, 20), 1);
  session.Add(ScriptedNode(model, 2, 1, {}, 20), 2);
  const auto loop_age = [&](std::size_t user) {
    const PeerTable& table = session.node(user).peer().table().Read();
    return table.count == 1 ? table.rows[0].loop_age_s : -1.0;
  };
  const auto run = [&](int frames) {
    for (int i = 0; i < frames; ++i) session.Step();
  };
  run(3000);
  EXPECT_NEAR(loop_age(0), 0.04, 0.004);
  EXPECT_NEAR(loop_age(1), 0.04, 0.004);
  session.node(1).peer().commands().TryPush({Command::Kind::kRelease, kNoObject, 0});
  run(700);
  EXPECT_EQ(loop_age(0), 0.0);
  EXPECT_EQ(loop_age(1), 0.0);
  session.node(1).peer().commands().TryPush({Command::Kind::kGrab, 1, 0});
  run(700);
  EXPECT_NEAR(loop_age(0), 0.04, 0.004);
  EXPECT_NEAR(loop_age(1), 0.04, 0.004);
}

}  // namespace
}  // namespace tandem
