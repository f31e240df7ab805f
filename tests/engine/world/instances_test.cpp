#include "engine/world/instances.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "engine/world/world.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::HandTo;
using testing::kVoxel;
using testing::MakeWorldModel;

/// The instance of the block, and the second one that it has while it is shared.
constexpr InstanceIndex kBlock = 1;
constexpr InstanceIndex kBlocksSecond = 2;

TriangleMesh CubeAt(double x) {
  return At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(x, 0, 0));
}

TriangleMesh BlockAt(double x) {
  return At(Box(Vec3(0.02, 0.04, 0.04)), Vec3(x, 0, 0));
}

/// A cube at the origin that a hand moves, and a block 60 mm beside it that may be shared.
struct CubeAndBlock {
  explicit CubeAndBlock(bool shared) : model(MakeModel(shared)), world(model) {
    inputs = ParkedInputs(*model);
    inputs.instances[0].drive = BodyDrive::kSimulated;
  }
  static std::shared_ptr<const WorldModel> MakeModel(bool shared) {
    auto made =
        std::make_shared<WorldModel>(*MakeWorldModel({{CubeAt(0)}, {BlockAt(0.06)}}, kVoxel));
    made->scene.bodies[1].shared = shared;
    return made;
  }
  /// Moves the hand with the cube to `x` in 400 frames, then holds it there; returns whether the
  /// cube was pushed by another body.
  bool MoveHandTo(double x) {
    bool pushed = false;
    for (int frame = 1; frame <= 800; ++frame) {
      const double share = std::min(1.0, frame / 400.0);
      inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(share * x, 0, 0)});
      const StepReport& report = world.Step(inputs);
      pushed = pushed || world.Pushed(0);
      contacts += report.contact_points;
    }
    return pushed;
  }
  double x_of(InstanceIndex instance) const { return world.state(instance).X_WB.p.x(); }

  std::shared_ptr<const WorldModel> model;
  World world;
  StepInputs inputs;
  int contacts = 0;  // contact points of all frames
};

TEST(Instances, SharedBodyHasTwoInstancesAndOthersHaveOne) {
  auto model = std::make_shared<WorldModel>(
      *MakeWorldModel({{CubeAt(0)}, {CubeAt(0.05)}, {CubeAt(0.1)}, {CubeAt(0.15)}}, kVoxel));
  model->scene.bodies[1].shared = true;
  model->scene.bodies[3].shared = true;
  const std::vector<std::size_t> shapes{0, 1, 2, 3, 1, 3};
  EXPECT_EQ(InstanceShapes(*model), shapes);
  const World world(model);
  ASSERT_EQ(world.instance_count(), shapes.size());
  for (InstanceIndex i = 0; i < shapes.size(); ++i) {
    EXPECT_EQ(world.shape_of(i), shapes[i]) << i;
    EXPECT_EQ(world.state(i).X_WB.p, model->bodies[shapes[i]].X_WB0.p) << i;
  }
}

TEST(Instances, SoleSharedBodyHasOneInstance) {
  auto model = std::make_shared<WorldModel>(*MakeWorldModel({{CubeAt(0)}}, kVoxel));
  model->scene.bodies[0].shared = true;
  EXPECT_EQ(InstanceShapes(*model), std::vector<std::size_t>{0});
  EXPECT_EQ(World(model).instance_count(), 1U);
}

TEST(Instances, ParkedInputsParkFirstAndDeactivateSecondInstances) {
  const StepInputs inputs = ParkedInputs(*CubeAndBlock::MakeModel(true));
  ASSERT_EQ(inputs.instances.size(), 3U);
  EXPECT_EQ(inputs.instances[0].drive, BodyDrive::kParked);
  EXPECT_EQ(inputs.instances[kBlock].drive, BodyDrive::kParked);
  EXPECT_EQ(inputs.instances[kBlocksSecond].drive, BodyDrive::kInactive);
  EXPECT_EQ(inputs.hand.body, -1);
}

// The hand goes through the place of the block as if the block were not there.
TEST(Instances, InactiveInstanceHasNoContact) {
  kHapticThread.Enter();
  CubeAndBlock inactive(false);
  inactive.inputs.instances[kBlock].drive = BodyDrive::kInactive;
  EXPECT_FALSE(inactive.MoveHandTo(0.06));
  EXPECT_EQ(inactive.contacts, 0);
  EXPECT_FALSE(inactive.world.Touched(kBlock));
  EXPECT_NEAR(inactive.x_of(0), 0.06, 1e-3);
  EXPECT_EQ(inactive.x_of(kBlock), inactive.model->bodies[kBlock].X_WB0.p.x());
  // a parked block stops the same hand, and a simulated one is pushed away
  CubeAndBlock parked(false);
  EXPECT_TRUE(parked.MoveHandTo(0.06));
  EXPECT_LT(parked.x_of(0), 0.041);
  CubeAndBlock simulated(false);
  simulated.inputs.instances[kBlock].drive = BodyDrive::kSimulated;
  EXPECT_TRUE(simulated.MoveHandTo(0.06));
  EXPECT_GT(simulated.x_of(kBlock), 0.065);
}

// The block is mirrored far beside the cube's way. Its second instance stays with it and stops
// nobody until the inputs put it on that way.
TEST(Instances, InactiveSecondInstanceFollowsTheFirst) {
  kHapticThread.Enter();
  CubeAndBlock both(true);
  StepInputs::InstanceInput& first = both.inputs.instances[kBlock];
  first.drive = BodyDrive::kMirrored;
  first.mirror_WB = {Quat::Identity(), Vec3(0, 0.2, 0)};
  const auto wait_for_mirrors = [&both] {  // their travel is limited
    bool met = false;
    for (int i = 0; i < 5; ++i) met = both.MoveHandTo(0) || met;
    return met;
  };
  EXPECT_FALSE(wait_for_mirrors());
  EXPECT_EQ(both.world.state(kBlocksSecond).X_WB.p, both.world.state(kBlock).X_WB.p);
  EXPECT_NEAR((both.world.state(kBlock).X_WB.p - Vec3(0, 0.2, 0)).norm(), 0, 1e-9);
  EXPECT_FALSE(both.MoveHandTo(0.06));
  EXPECT_NEAR(both.x_of(0), 0.06, 1e-3);
  EXPECT_FALSE(both.MoveHandTo(0));
  StepInputs::InstanceInput& second = both.inputs.instances[kBlocksSecond];
  second.drive = BodyDrive::kMirrored;
  second.mirror_WB = {Quat::Identity(), Vec3(0.06, 0, 0)};
  EXPECT_FALSE(wait_for_mirrors());
  EXPECT_NEAR(both.x_of(kBlocksSecond), 0.06, 1e-9);
  EXPECT_NEAR((both.world.state(kBlock).X_WB.p - Vec3(0, 0.2, 0)).norm(), 0, 1e-9);
  EXPECT_TRUE(both.MoveHandTo(0.06));
  EXPECT_TRUE(both.world.Pushed(kBlocksSecond));
  EXPECT_FALSE(both.world.Pushed(kBlock));
  EXPECT_LT(both.x_of(0), 0.041);
}

}  // namespace
}  // namespace tandem
