#include "collab/separation/instance_separation.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;

constexpr PeerId kAnna = 1;

/// Returns a wall in the plane x = 0 that ends at y = 0, and a shared cube, which stands above its
/// edge.
std::shared_ptr<const WorldModel> WallAndCube() {
  const TriangleMesh wall = At(Box(Vec3(0.004, 0.2, 0.1)), Vec3(0, -0.1, 0));
  const TriangleMesh cube = At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0, 0.03, 0));
  auto model =
      std::make_shared<WorldModel>(*testing::MakeWorldModel({{wall, true}, {cube}}, 0.002));
  model->scene.bodies[1].shared = true;
  return model;
}

/// Anna and another peer hold the cube, on two sides of the wall if they like.
class InstanceSeparationTest : public ::testing::Test {
 protected:
  InstanceSeparationTest() {
    separation.Begin(0);
    shared.Join(kAnna);
  }
  /// Runs a frame in which both are `aside` of the wall's plane, and `down` from above its edge.
  void Frame(double aside, double down, double ours_further) {
    ObjectState theirs;
    theirs.peer = kAnna;
    theirs.object = 1;
    theirs.seq = ++seq;
    theirs.X_WB.p = Vec3(aside, 0.03 - down, 0);
    shared.OnState(theirs);
    own.X_WB.p = Vec3(-aside - ours_further, 0.03 - down, 0);
    separation.Update(seq * kMs, own, shared);
    hand = {};
    hand.gains.stiffness = 1;
    separation.GuideHand(own, own.X_WB, X_BD, hand);
  }
  void GoApart() {
    for (int i = 0; i < 500; ++i) Frame(0, 0, 0);
    for (int i = 0; i < 500; ++i) Frame(1e-4 * i, 0, 0);
    for (int i = 0; i < 500; ++i) Frame(0.05, 2e-4 * i, 0);
  }

  const std::shared_ptr<const WorldModel> model = WallAndCube();
  InstanceSeparation separation{2, *model};
  SharedBody shared{2, 1, model->bodies[0].inertia, {}};
  RigidState own;
  Pose X_BD;
  StepInputs::Hand hand;
  std::uint32_t seq = 0;
};

// The body moves on while the hand lets go of it. The lead then begins where the body is, and does
// not tear it back to where it was when the way was found.
TEST_F(InstanceSeparationTest, LeadsAReleasedBodyFromItsCurrentPose) {
  GoApart();
  ASSERT_TRUE(separation.apart());
  separation.RequestReunion();
  int moving = 0;  // frames, at 0.5 m/s
  while (!separation.guiding() && moving < 1000) Frame(0.05, 0.1, 5e-4 * ++moving);
  ASSERT_TRUE(separation.guiding());
  EXPECT_GT(moving, 190);
  const Vec3 lift = -model->bodies[0].inertia.mass / hand.gains.stiffness * model->scene.gravity_W;
  EXPECT_LT((hand.goal.X_WA.p - lift - own.X_WB.p).norm(), 1e-6);
}

// Anna says that she is where she likes, and asks all the time. The body does not leave our hand at
// each of her words.
TEST_F(InstanceSeparationTest, YieldsToTheCoupledPeerTwiceThenOnceEveryHalfAMinute) {
  int led = 0;
  const auto stay_apart = [&](bool by_user) {
    const bool before = separation.guiding();
    by_user ? separation.RequestReunion() : separation.RequestReunionForPeer();
    Frame(0.05, 0.1, 0);
    if (!before && separation.guiding()) ++led;
  };
  GoApart();
  for (int i = 0; i < 100'000; ++i) {
    stay_apart(false);
    if (separation.guiding() && i % 1000 == 999) GoApart();  // as if it had come
  }
  EXPECT_GE(led, 2);
  EXPECT_LE(led, 2 + static_cast<int>(seq / 30'000));  // a frame has a millisecond
  led = 0;
  for (int i = 0; i < 10'000 && led == 0; ++i) stay_apart(true);
  EXPECT_EQ(led, 1) << "our own user may always ask";
}

}  // namespace
}  // namespace tandem
