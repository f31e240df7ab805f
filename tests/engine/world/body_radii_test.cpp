#include "engine/world/body_radii.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/round_shapes.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::Cylinder;
using testing::FreeInputs;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RandomDirection;
using testing::RandomRotation;

constexpr double kRodRadius = 0.005;
constexpr double kRodLength = 0.06;

// Against the vertices one by one.
TEST(AxisRadii, BoundTheDistanceOfEveryVertexFromTheAxis) {
  std::mt19937_64 random(11);
  for (const TriangleMesh& mesh : {Cylinder(kRodRadius, kRodLength, 48),
                                   Box(Vec3(0.03, 0.02, 0.008)), testing::Sphere(0.01, 3)}) {
    const auto model =
        MakeWorldModel({{At(mesh, Vec3(0.1, 0, 0), RandomRotation(random))}}, kVoxel);
    const AxisRadii radii = AxisRadiiOf(*model, 0);
    const std::vector<Vec3> corners = testing::CornersOf(*model, 0);
    for (int trial = 0; trial < 500; ++trial) {
      const Vec3 way = RandomDirection(random);
      double farthest = 0;
      for (const Vec3& p_B : corners) farthest = std::max(farthest, p_B.cross(way).norm());
      ASSERT_LE(farthest, radii.About(3.0 * way));
      ASSERT_LE(radii.About(3.0 * way), radii.radius);
    }
  }
}

TEST(AxisRadii, ASlenderCylinderIsThinAboutItsOwnAxis) {
  const auto model = MakeWorldModel({{Cylinder(kRodRadius, kRodLength, 48)}}, kVoxel);
  const AxisRadii radii = AxisRadiiOf(*model, 0);
  EXPECT_NEAR(radii.About(Vec3::UnitY()), kRodRadius, 1e-6);
  EXPECT_NEAR(radii.About(Vec3::UnitX()), std::hypot(kRodRadius, 0.5 * kRodLength), 1e-6);
}

// It spins fast, about its axis and about others, beside a wall: no vertex goes farther in a frame
// than the travel limit, half a voxel, and about its own axis it keeps its speed. A body moved by
// this peer's forces, and one that another peer moves.
TEST(AxisRadii, ASlenderBodySpinsBesideAWallWithinTheTravelLimit) {
  kHapticThread.Enter();
  for (const bool mirrored : {false, true}) {
    for (const Vec3& w_B : {Vec3(0, 90, 0), Vec3(0, 140, 0), Vec3(3, 85, 0), Vec3(0, 40, 60)}) {
      // a mirror is held back where it may meet a body of this peer
      const auto model = MakeWorldModel(
          {{At(Cylinder(kRodRadius, kRodLength, 48), Vec3(0, 0, kRodRadius + 0.5 * kVoxel))},
           {At(Box(Vec3(0.2, 0.2, 0.01)), Vec3(0, 0, -0.005)), !mirrored, 5}},
          kVoxel);
      World world(model);
      StepInputs inputs = FreeInputs(*model);
      StepInputs::InstanceInput& input = inputs.instances[0];
      const std::vector<Vec3> corners = testing::CornersOf(*model, 0);
      input.drive = BodyDrive::kMirrored;
      input.mirror_WB = model->bodies[0].X_WB0;
      world.Step(inputs);
      if (!mirrored) input.drive = BodyDrive::kSimulated;
      input.begin_V_WB.w = input.mirror_WB.q * w_B;
      for (int frame = 0; frame < 100; ++frame) {
        const Pose before = world.state(0).X_WB;
        input.mirror_WB.q = before.q * RotationBy(kFrame * w_B);
        world.Step(inputs);
        double most = 0;
        for (const Vec3& p_B : corners) {
          most = std::max(most, (world.state(0).X_WB * p_B - before * p_B).norm());
        }
        ASSERT_LE(most, 0.5 * kVoxel * (1 + 1e-9)) << w_B.transpose();
      }
      if (!mirrored && w_B == Vec3(0, 90, 0)) {
        EXPECT_NEAR(world.state(0).V_WB.w.norm(), 90, 0.1);
      }
    }
  }
}

}  // namespace
}  // namespace tandem
