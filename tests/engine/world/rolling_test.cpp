// Tests balls and cylinders that roll down planes against the textbook.
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::Sphere;

constexpr double kGravity = 9.81;

/// Returns a closed cylinder along y, of `sides` flat sides.
TriangleMesh Cylinder(double radius, double length, std::uint32_t sides) {
  TriangleMesh mesh;
  for (const double end : {-0.5, 0.5}) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.vertices.emplace_back(radius * std::cos(angle), end * length, radius * std::sin(angle));
    }
  }
  mesh.vertices.emplace_back(0, -0.5 * length, 0);
  mesh.vertices.emplace_back(0, 0.5 * length, 0);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t next = (i + 1) % sides;
    mesh.triangles.push_back({i, sides + i, next});
    mesh.triangles.push_back({next, sides + i, sides + next});
    mesh.triangles.push_back({2 * sides, i, next});
    mesh.triangles.push_back({2 * sides + 1, sides + next, sides + i});
  }
  return mesh;
}

struct Roller {
  std::string name;
  TriangleMesh mesh;
  double radius;
  double mass;
  double share;  // of g sin(angle) by which it accelerates: 5/7 or 2/3
};

/// Returns the acceleration down a plane from 0.02 m/s up to 0.2 m/s, at which the top of the
/// roller goes 0.8 of half a voxel a frame.
double AccelerationOf(const Roller& roller, double degrees, bool tilted) {
  kHapticThread.Enter();
  const double angle = degrees * std::numbers::pi / 180;
  const Quat q = RotationBy(Vec3(0, tilted ? angle : 0.0, 0));
  auto model = std::make_shared<WorldModel>(*MakeWorldModel(
      {{At(Box(Vec3(0.3, 0.06, 0.006)), q * Vec3(0.1, 0, -0.003), q), true},
       {At(roller.mesh, q * Vec3(0, 0, roller.radius + 0.45 * kVoxel), q), false, roller.mass}},
      kVoxel));
  model->scene.friction = 0.5;
  model->scene.gravity_W = q * (RotationBy(Vec3(0, -angle, 0)) * Vec3(0, 0, -kGravity));
  World world(model);
  const StepInputs inputs = FreeInputs(*model);
  const Vec3 down = q * Vec3::UnitX();
  double begin = -1;
  double from = 0;
  double speed = 0;
  int frame = 0;
  for (; frame < 3000 && speed < 0.2; ++frame) {
    world.Step(inputs);
    speed = world.state(0).V_WB.v.dot(down);
    if (begin < 0 && speed > 0.02) {
      begin = frame;
      from = speed;
    }
  }
  return (speed - from) / ((frame - 1 - begin) * kFrame);
}

TEST(Rolling, BallsAndCylindersAccelerateAsTheTextbookSays) {
  const std::array<Roller, 3> rollers{
      Roller{"ball", testing::At(Sphere(0.010, 4), Vec3::Zero(), RotationBy(Vec3(0.3, 0.7, -0.4))),
             0.010, 0.3, 5.0 / 7},
      Roller{"small light ball", Sphere(0.005, 4), 0.005, 0.0014, 5.0 / 7},
      Roller{"cylinder", Cylinder(0.010, 0.02, 64), 0.010, 0.017, 2.0 / 3}};
  for (const Roller& roller : rollers) {
    for (const double degrees : {5.0, 10.0, 20.0}) {
      for (const bool tilted : {false, true}) {
        const double expected =
            roller.share * kGravity * std::sin(degrees * std::numbers::pi / 180);
        EXPECT_NEAR(AccelerationOf(roller, degrees, tilted), expected, 0.03 * expected)
            << roller.name << ", " << degrees << ", " << tilted;
      }
    }
  }
}

}  // namespace
}  // namespace tandem
