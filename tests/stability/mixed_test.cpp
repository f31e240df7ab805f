#include <gtest/gtest.h>

#include "collab/coupling/coupling_law.h"
#include "collab/mirror/mirror_compliance.h"
#include "collab/simulated/network/simulated_session.h"
#include "tests/support/scripted_node.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::Box;
using testing::MakeWorldModel;
using testing::ScriptedNode;

constexpr double kCubeSide = 0.03;            // m, of both cubes
constexpr InstanceIndex kSecondInstance = 2;  // the shared cube's, in the third peer's world

/// Returns a shared cube at the origin, and an own one 120 mm beside it.
std::shared_ptr<const WorldModel> TwoCubes() {
  auto model = std::make_shared<WorldModel>(
      *MakeWorldModel({{Box(Vec3(kCubeSide, kCubeSide, kCubeSide))},
                       {Transformed(Box(Vec3(kCubeSide, kCubeSide, kCubeSide)),
                                    {Quat::Identity(), Vec3(0.12, 0, 0)})}},
                      0.002));
  model->scene.bodies[0].shared = true;
  return model;
}

std::vector<Waypoint> Go(const Vec3& by) {
  return {{0, Vec3::Zero(), Quat::Identity()}, {1, by, Quat::Identity()}};
}

const Vec3& Held(SimulatedSession& session, std::size_t peer) {
  return session.node(peer).peer().held_state()->X_WB.p;
}

// Two peers, or four, hold the cube some way apart. The peer that does not hold it sees one cube,
// at their mean.
TEST(Mixed, ThirdPeerMeetsASharedBodyAtTheMeanOfItsInstances) {
  const auto model = TwoCubes();
  for (const std::size_t holders : {2U, 4U}) {
    SimulatedSession session;
    for (std::size_t h = 0; h < holders; ++h) {
      const Vec3 by(0, h % 2 == 0 ? 0.02 : -0.01, 0);
      session.Add(ScriptedNode(model, 1 + h, 0, Go(by), 20), 1 + h);
    }
    session.Add(ScriptedNode(model, 9, 1, {}, 20), 9);
    for (int i = 0; i < 6000; ++i) session.Step();
    Vec3 mean = Vec3::Zero();
    for (std::size_t h = 0; h < holders; ++h) {
      mean += Held(session, h) / static_cast<double>(holders);
    }
    EXPECT_GT((Held(session, 0) - Held(session, 1)).norm(), 0.002);
    const World& world = session.node(holders).world();
    EXPECT_LT((world.state(0).X_WB.p - mean).norm(), 5e-4) << holders;
    EXPECT_EQ(world.state(kSecondInstance).X_WB.p, world.state(0).X_WB.p);
  }
}

// The instances part for good. Then there are two cubes, and the third peer runs into each of them.
TEST(Mixed, SeparatedInstancesBothMakeContact) {
  const auto model = TwoCubes();
  for (const std::size_t holders : {2U, 4U}) {
    for (const double side : {0.06, -0.06}) {
      SCOPED_TRACE(std::to_string(holders) + " holders, " + std::to_string(side));
      SimulatedSession session;
      for (std::size_t h = 0; h < holders; ++h) {
        const Vec3 by(0, h % 2 == 0 ? 0.08 : -0.08, 0);
        session.Add(ScriptedNode(model, 1 + h, 0, Go(by), 300), 1 + h);
      }
      // over to one of them, then against it
      session.Add(ScriptedNode(model, 9, 1,
                               {{0, Vec3::Zero(), Quat::Identity()},
                                {3, Vec3::Zero(), Quat::Identity()},
                                {4, Vec3(0, side, 0), Quat::Identity()},
                                {6, Vec3(-0.11, side, 0), Quat::Identity()}},
                               300),
                  9);
      double least = 1e9;
      for (int i = 0; i < 9000; ++i) {
        session.Step();
        if (session.node(holders).peer().held_state() == nullptr) continue;  // not granted yet
        const World& world = session.node(holders).world();
        for (const Vec3& p : {world.state(0).X_WB.p, world.state(kSecondInstance).X_WB.p}) {
          least = std::min(least, (p - Held(session, holders)).norm());
        }
      }
      const World& world = session.node(holders).world();
      EXPECT_GT((world.state(0).X_WB.p - world.state(kSecondInstance).X_WB.p).norm(), 0.04);
      const double felt = session.node(holders).peer().report().hand_B_W.f.norm();
      // in series: my hand and its coupling, the instance's, and the mirror that gives way by B/te
      const double k_hand = 1.0 / (1.0 / 300.0 + 1.0 / 800.0);
      const double k_mirror = MirrorCompliance::kDrag / DesignDelay(0.602);
      const double overlap = kCubeSide - 0.01 + 0.45 * 0.002;  // wanted; and where contact begins
      EXPECT_NEAR(felt, overlap / (2.0 / k_hand + 1.0 / k_mirror), 0.03);
      EXPECT_GT(least, kCubeSide);  // centres of cubes that do not overlap
    }
  }
}

}  // namespace
}  // namespace tandem
