#include "collab/mirror/mirror_compliance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "tests/support/scripted_node.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::Box;
using testing::MakeWorldModel;
using testing::ScriptedNode;

TEST(MirrorCompliance, StartsFirmAndSoftensToTheDelaysLimit) {
  MirrorCompliance blend;
  blend.Next(false, 0.1, 0, 1e-3);
  EXPECT_FALSE(blend.compliant());
  blend.Next(true, 0.1, 0, 1e-3);
  EXPECT_GT(blend.stiffness(), 0.95 * MirrorCompliance::kFirm);
  for (int i = 0; i < 400; ++i) blend.Next(true, 0.1, 0.01, 1e-3);
  EXPECT_NEAR(blend.stiffness(), 100, 2);
  // off it again: the mirror is firm, and follows as soon as it is back
  for (int i = 0; i < 400; ++i) blend.Next(false, 0.1, 0.01, 1e-3);
  EXPECT_TRUE(blend.compliant());
  EXPECT_NEAR(blend.stiffness() * 0.01, MirrorCompliance::kMostPull, 1e-9);  // but not with more
  blend.Next(false, 0.1, 1e-5, 1e-3);
  EXPECT_FALSE(blend.compliant());
}

TEST(MirrorCompliance, StaysFirmAtShortDelay) {
  MirrorCompliance blend;
  for (int i = 0; i < 1000; ++i) blend.Next(true, 0.004, 0, 1e-3);
  EXPECT_FALSE(blend.compliant());
}

std::vector<Waypoint> Shift(const Vec3& by, double seconds) {
  return {{0, Vec3::Zero(), Quat::Identity()}, {seconds, by, Quat::Identity()}};
}

// Two press one another, with 40 mm of overlap wanted, at every delay. They come to rest.
TEST(Type1, PressingPartsComeToRestAtEveryDelay) {
  const auto model = MakeWorldModel(
      {{Transformed(Box(Vec3(0.03, 0.03, 0.03)), {Quat::Identity(), Vec3(-0.05, 0, 0)})},
       {Transformed(Box(Vec3(0.03, 0.03, 0.03)), {Quat::Identity(), Vec3(0.05, 0, 0)})}},
      0.002);
  for (const double tau_ms : {20.0, 100.0, 300.0}) {
    SimulatedSession session;
    session.Add(ScriptedNode(model, 1, 0, Shift(Vec3(0.055, 0, 0), 1), tau_ms), 1);
    session.Add(ScriptedNode(model, 2, 1, Shift(Vec3(-0.055, 0, 0), 1), tau_ms), 2);
    std::array<double, 2> least{1e9, 1e9}, most{-1e9, -1e9};
    double peak = 0;
    bool rests = true;  // against one another, in every frame
    for (int i = 0; i < 10000; ++i) {
      session.Step();
      for (std::size_t p = 0; p < 2; ++p) {
        const Peer& peer = session.node(p).peer();
        peak = std::max(peak, peer.report().hand_B_W.f.norm());
        if (i < 8000) continue;
        rests = rests && peer.report().pushing_points > 0;
        least[p] = std::min(least[p], peer.held_state()->X_WB.p.x());
        most[p] = std::max(most[p], peer.held_state()->X_WB.p.x());
        // no user sees the parts pass through one another
        const World& world = session.node(p).world();
        ASSERT_GT(world.state(1).X_WB.p.x() - world.state(0).X_WB.p.x(), 0.029) << tau_ms;
      }
    }
    EXPECT_LT(most[0] - least[0], 1e-3) << tau_ms;
    EXPECT_LT(most[1] - least[1], 1e-3) << tau_ms;
    EXPECT_LT(peak, 20) << tau_ms;
    EXPECT_TRUE(rests) << tau_ms;
  }
}

// The other's part is cut off in front of our thin wall and comes back behind it. Its mirror goes
// there by its share of the travel limit, and nothing of the holder of our wall is pushed or jumps.
TEST(Type1, MirrorReturningBehindAThinWallDoesNotPullOurBodyThrough) {
  const auto model = MakeWorldModel(
      {{Transformed(Box(Vec3(0.004, 0.06, 0.06)), {Quat::Identity(), Vec3(0, 0, 0)})},
       {Transformed(Box(Vec3(0.02, 0.02, 0.02)), {Quat::Identity(), Vec3(0.04, 0, 0)})}},
      0.002);
  SimulatedSession session;
  session.Add(ScriptedNode(model, 1, 0, {}, 20), 1);
  session.Add(ScriptedNode(model, 2, 1,
                           {{0, Vec3::Zero(), Quat::Identity()},
                            {1.9, Vec3::Zero(), Quat::Identity()},
                            {2.1, Vec3(0, 0.1, 0), Quat::Identity()},
                            {2.25, Vec3(-0.08, 0.1, 0), Quat::Identity()},
                            {2.4, Vec3(-0.08, 0, 0), Quat::Identity()}},
                           20),
              2);
  const World& world = session.node(0).world();
  Vec3 last_force = Vec3::Zero();
  double largest_step = 0, peak = 0, lag = 0;
  Vec3 last = world.state(1).X_WB.p;
  for (int i = 0; i < 6000; ++i) {
    if (i == 2000) session.network().Cut(2, 1, true);
    if (i == 2500) session.network().Cut(2, 1, false);
    session.Step();
    const Peer& peer = session.node(0).peer();
    const Vec3& force = peer.report().hand_B_W.f;
    if (i > 0) largest_step = std::max(largest_step, (force - last_force).norm());
    last_force = force;
    peak = std::max(peak, force.norm());
    lag = std::max(lag, peer.mirror_lag_m());
    last = world.state(1).X_WB.p;
    // the ball within the cube stays out of the plate, by exact geometry
    const Vec3 d = world.state(0).X_WB.Inverse() * world.state(1).X_WB.p;
    const bool apart = std::abs(d.x()) > 0.012 || std::abs(d.y()) > 0.03;
    ASSERT_TRUE(apart) << "frame " << i << ": " << d.transpose();
  }
  EXPECT_LE(largest_step, 2.0);  // N a frame: the slew of the device
  EXPECT_LE(peak, 12.0);
  EXPECT_GT(lag, 0.05);        // the lag is told while the mirror is held up
  EXPECT_LT(last.x(), -0.01);  // in the end it is behind
}

}  // namespace
}  // namespace tandem
