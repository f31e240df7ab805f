// Tests bodies that follow what other peers say of them.
#include <gtest/gtest.h>

#include "engine/world/world.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RunFrames;
using testing::Sphere;

// The other peer's part re-appears behind ours after an outage: its mirror must walk there, not
// jump.
TEST(World, JumpingMirrorDoesNotTunnel) {
  kHapticThread.Enter();
  const TriangleMesh mine = At(Box(Vec3(0.04, 0.04, 0.003)), Vec3(0, 0, 0));
  const TriangleMesh theirs = At(Sphere(0.008, 3), Vec3(0, 0, 0.03));
  const auto model = MakeWorldModel({{mine}, {theirs}}, kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.hand = HandTo(*model, 0, Pose{});
  inputs.instances[1].drive = BodyDrive::kMirrored;
  inputs.instances[1].mirror_WB.p = Vec3(0, 0, -0.03);
  double largest_step = 0;
  bool touched = false;
  for (int frame = 0; frame < 600; ++frame) {
    const Vec3 before = world.state(1).X_WB.p;
    // the mirror may walk faster where nothing is near
    const double gap = std::abs(before.z() - world.state(0).X_WB.p.z()) - 0.0015 - 0.008;
    const bool near = gap < 0.9 * kVoxel;
    const StepReport report = world.Step(inputs);
    touched = report.pushing_points > 0 || touched;
    if (near) largest_step = std::max(largest_step, (world.state(1).X_WB.p - before).norm());
    // ours is pushed along: the mirror's centre never gets past our middle
    ASSERT_GT(world.state(1).X_WB.p.z(), world.state(0).X_WB.p.z()) << "frame " << frame;
  }
  EXPECT_TRUE(touched);
  EXPECT_LE(largest_step, 0.25 * kVoxel * 1.000001);  // half of the pair's half voxel
}

// A mirror may come 60 mm in a frame. The peer that takes it then takes no 60 m/s with it.
TEST(World, FormerMirrorStartsAtRest) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{Box(Vec3(0.02, 0.02, 0.02))}}, 0.002);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[0].drive = BodyDrive::kMirrored;
  inputs.instances[0].mirror_WB = model->bodies[0].X_WB0;
  inputs.instances[0].mirror_WB.p.x() += 0.06;
  inputs.instances[0].mirror_WB.q = RotationBy(Vec3(0, 0.2, 0)) * inputs.instances[0].mirror_WB.q;
  world.Step(inputs);
  const Pose X_WB = world.state(0).X_WB;
  ASSERT_GT(world.state(0).V_WB.v.norm(), 10);
  inputs.instances[0].drive = BodyDrive::kSimulated;
  inputs.hand = testing::HandTo(*model, 0, X_WB);
  EXPECT_LT(world.Step(inputs).hand_B_W.f.norm(), 1e-9);
  EXPECT_LT((world.state(0).X_WB.p - X_WB.p).norm(), 1e-12);
  // a body that forces move keeps its way
  inputs.hand.goal.X_WA.p.x() += 0.01;
  world.Step(inputs);
  EXPECT_GT(world.state(0).V_WB.v.x(), 0.01);
}

// The speed of a body that somebody throws is told, and the peer that takes it over lets it fly on.
TEST(World, FormerMirrorStartsAtItsInputTwist) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{Box(Vec3(0.02, 0.02, 0.02))}}, 0.002);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[0].drive = BodyDrive::kMirrored;
  inputs.instances[0].mirror_WB = model->bodies[0].X_WB0;
  world.Step(inputs);
  inputs.instances[0].drive = BodyDrive::kSimulated;
  inputs.instances[0].begin_V_WB = {Vec3(0, 0, 1), Vec3(0.5, 0, 0)};
  world.Step(inputs);
  EXPECT_NEAR(world.state(0).V_WB.v.x(), 0.5, 1e-9);
  EXPECT_NEAR(world.state(0).V_WB.w.z(), 1.0, 1e-9);
  // from then on it is its own
  inputs.instances[0].begin_V_WB = {};
  world.Step(inputs);
  EXPECT_NEAR(world.state(0).V_WB.v.x(), 0.5, 1e-9);
}

// A mirror that can meet nothing here follows its pose at once, as its own peer moves it.
TEST(World, FreeMirrorFollowsItsPoseAtFullSpeed) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel(
      {{At(Box(Vec3(0.2, 0.2, 0.01)), Vec3(0, 0, -0.2)), true}, {Sphere(0.01, 3)}}, kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[0].drive = BodyDrive::kMirrored;
  inputs.instances[0].mirror_WB.p = Vec3(0.1, 0, 0);
  RunFrames(world, inputs, 5);
  EXPECT_LT((world.state(0).X_WB.p - Vec3(0.1, 0, 0)).norm(), 1e-9);
}

}  // namespace
}  // namespace tandem
