#include "collab/session/peer_table.h"

#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;

/// Returns a shared cube at the origin, and an own one beside it, in free space.
std::shared_ptr<const WorldModel> TwoCubes() {
  static const std::shared_ptr<const WorldModel> kModel = [] {
    const Vec3 size(0.02, 0.02, 0.02);
    auto model = std::make_shared<WorldModel>(
        *testing::MakeWorldModel({{Box(size)}, {At(Box(size), Vec3(0.2, 0, 0))}}, 0.002));
    model->scene.bodies[0].shared = true;
    return model;
  }();
  return kModel;
}

std::unique_ptr<PeerNode> Hand(PeerId id, int object, const Vec3& by, double delay_ms,
                               std::size_t wait_for = 1) {
  const auto model = TwoCubes();
  HandScript script;
  script.waypoints = {{0, Vec3::Zero(), Quat::Identity()}, {1, by, Quat::Identity()}};
  NodeOptions options;
  options.peer.id = id;
  options.peer.held_object = object;
  options.peer.wait_for = wait_for;
  options.conditions.delay_ms = delay_ms;
  const Pose& X_WB0 = model->bodies[static_cast<std::size_t>(object)].X_WB0;
  return std::make_unique<PeerNode>(model, std::make_unique<ScriptedDevice>(script, X_WB0), 42,
                                    options);
}

const PeerTableRow* RowOf(const PeerTable& table, PeerId peer) {
  for (std::uint32_t i = 0; i < table.count; ++i) {
    if (table.rows[i].peer == peer) return &table.rows[i];
  }
  return nullptr;
}

// Two hands pull one part apart and rest. Both peers tell the same of their link, whatever the
// delay, and its two wrenches agree within 5 %.
TEST(PeerTable, BothEndsOfALinkAgreeAtRest) {
  for (const double delay_ms : {1.0, 20.0, 100.0, 300.0}) {
    SCOPED_TRACE(delay_ms);
    SimulatedSession session;
    session.Add(Hand(1, 0, Vec3(0.03, 0, 0), delay_ms), 1);
    session.Add(Hand(2, 0, Vec3(-0.03, 0, 0), delay_ms), 2);
    for (int i = 0; i < 10000; ++i) session.Step();
    for (const std::size_t user : {0U, 1U}) {
      const PeerTable& table = session.node(user).peer().table().Read();
      ASSERT_EQ(table.count, 1U);
      const PeerTableRow& row = table.rows[0];
      EXPECT_EQ(row.peer, session.id(1 - user));
      EXPECT_TRUE(row.coupled);
      EXPECT_FALSE(row.trapped);
      EXPECT_GT(row.link_force, 0.3);
      EXPECT_LT(row.disagreement, 0.05);
      EXPECT_NEAR(row.its_link_force, row.link_force, 0.05 * row.link_force);
      const double apart = (session.node(0).peer().held_state()->X_WB.p -
                            session.node(1).peer().held_state()->X_WB.p)
                               .norm();
      EXPECT_NEAR(row.link_force, row.stiffness * apart, 0.02 * row.link_force);
      EXPECT_NEAR(row.loop_age_s, 2e-3 * delay_ms, 0.004);
      EXPECT_NEAR(row.delay_s, 0.5 * row.loop_age_s, 1e-12);
      EXPECT_GE(row.mirror_age_s, 0.0);
      EXPECT_LT(row.mirror_age_s, 0.002);  // a state a frame
      EXPECT_EQ(row.drops, session.node(user).inbox().drops().CountsOf(row.peer));
    }
  }
}

// A peer that lets go is coupled no more, while its pull still fades and after.
TEST(PeerTable, ReleasingPeerIsUncoupled) {
  SimulatedSession session;
  session.Add(Hand(1, 0, Vec3(0.03, 0, 0), 20), 1);
  session.Add(Hand(2, 0, Vec3(-0.03, 0, 0), 20), 2);
  for (int i = 0; i < 4000; ++i) session.Step();
  const auto row = [&] {
    return *RowOf(session.node(0).peer().table().Read(), 2);
  };
  EXPECT_TRUE(row().coupled);
  session.node(1).peer().commands().TryPush({Command::Kind::kRelease, kNoObject, 0});
  bool fades = false;
  for (int i = 0; i < 200; ++i) session.Step();
  for (int i = 0; i < 2000; ++i) {
    session.Step();
    ASSERT_FALSE(row().coupled) << i;
    ASSERT_EQ(row().loop_age_s, 0.0) << i;
    fades = fades || row().stiffness > 0;
  }
  EXPECT_TRUE(fades);
}

// A third hand moves its own cube: the others have its delay and its mirror's lag, but no link.
TEST(PeerTable, ShowsPeersThatHoldOtherBodies) {
  SimulatedSession session;
  session.Add(Hand(1, 0, Vec3::Zero(), 50, 0), 1);
  session.Add(Hand(2, 1, Vec3(0.3, 0, 0), 50), 2);
  for (int i = 0; i < 700; ++i) session.Step();
  const PeerTableRow* row = RowOf(session.node(0).peer().table().Read(), 2);
  ASSERT_NE(row, nullptr);
  EXPECT_FALSE(row->coupled);
  EXPECT_EQ(row->link_force, 0.0);
  EXPECT_NEAR(row->loop_age_s, 0.1, 0.004);
  for (int i = 0; i < 3000; ++i) session.Step();
  row = RowOf(session.node(0).peer().table().Read(), 2);
  EXPECT_LT(row->mirror_lag_m, 1e-4);
  // a silent peer grows old in the table, a peer that is gone is not in it
  session.Halt(1, true);
  for (int i = 0; i < 400; ++i) session.Step();
  row = RowOf(session.node(0).peer().table().Read(), 2);
  ASSERT_NE(row, nullptr);
  EXPECT_NEAR(row->mirror_age_s, 0.35, 0.11);
  for (int i = 0; i < 1000; ++i) session.Step();
  EXPECT_EQ(session.node(0).peer().table().Read().count, 0U);
}

// One peer has no test to spare and is slowed to the travel floor. The other has all it needs.
TEST(PeerTable, ReportsEachPeersFrameLimits) {
  SimulatedSession session;
  auto slow = Hand(1, 0, Vec3(0.1, 0, 0), 20, 0);
  slow->peer().SetCapacity(0);
  session.Add(std::move(slow), 1);
  session.Add(Hand(2, 1, Vec3::Zero(), 20), 2);
  for (int i = 0; i < 3000; ++i) session.Step();
  const PeerTable& own = session.node(0).peer().table().Read();
  EXPECT_EQ(own.own_limits.over_capacity, 1);
  EXPECT_GT(own.own_limits.travel_limited, 0.5);
  EXPECT_EQ(own.own_limits.contacts_full, 0);
  const PeerTableRow* of_other = RowOf(own, 2);
  ASSERT_NE(of_other, nullptr);
  EXPECT_EQ(of_other->limits, FrameLimits{});
  const PeerTable& others = session.node(1).peer().table().Read();
  EXPECT_EQ(others.own_limits, FrameLimits{});
  const PeerTableRow* row = RowOf(others, 1);
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->limits.over_capacity, 1);
  EXPECT_NEAR(row->limits.travel_limited, own.own_limits.travel_limited, 0.02);
}

// A mirror held up by what it would run into is not where its peer says it is. The table says how
// far.
TEST(PeerTable, ShowsAMirrorsLag) {
  SimulatedSession session;
  session.Add(Hand(1, 0, Vec3(0.15, 0, 0), 200, 0), 1);
  session.Add(Hand(2, 1, Vec3(-0.05, 0, 0), 200), 2);
  for (int i = 0; i < 6000; ++i) session.Step();
  const PeerTableRow* row = RowOf(session.node(0).peer().table().Read(), 2);
  ASSERT_NE(row, nullptr);
  const double lag =
      (session.node(0).world().state(1).X_WB.p - session.node(1).peer().held_state()->X_WB.p)
          .norm();
  EXPECT_GT(lag, 0.002);
  EXPECT_NEAR(row->mirror_lag_m, lag, 0.002);
}

}  // namespace
}  // namespace tandem
