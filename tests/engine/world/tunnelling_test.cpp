// Tests how far bodies get into one another, by exact geometry.
#include <gtest/gtest.h>

#include "engine/geometry/exact/exact_surface.h"
#include "engine/world/world.h"
#include "tests/support/round_shapes.h"
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
using testing::RandomDirection;
using testing::RandomRotation;

/// Returns how deep the body's vertices are in a solid (m), by exact geometry.
double DeepestVertex(const ExactSurface& solid, const TriangleMesh& mesh_W, const Pose& X_WB0,
                     const Pose& X_WB) {
  const Pose X_W = X_WB * X_WB0.Inverse();
  double deepest = 0;
  for (const Vec3& vertex : mesh_W.vertices) {
    const Vec3 p = X_W * vertex;
    if (solid.Contains(p)) deepest = std::max(deepest, solid.Depth(p));
  }
  return deepest;
}

class NoTunnelling : public ::testing::TestWithParam<double> {};

// The goal is thrown through the plate in one frame, so that the hand pulls with all it has. The
// plate is one and three voxels thick. The body stays on its side and its exact surface out,
// whatever the direction.
TEST_P(NoTunnelling, ThrownBodyDoesNotTunnelThroughAThinPlate) {
  kHapticThread.Enter();
  const double thickness = GetParam() * kVoxel;
  std::mt19937_64 random(7);
  for (const double mass : {0.05, 0.3, 2.0}) {
    const TriangleMesh plate =
        At(Box(Vec3(0.08, 0.08, thickness)), Vec3(0, 0, -0.5 * thickness + 0.0004));
    const ExactSurface solid(plate);
    for (const double throw_length : {0.5, 5.0}) {
      const TriangleMesh body =
          At(Box(Vec3(0.016, 0.012, 0.010)), Vec3(0, 0, 0.02), RandomRotation(random));
      const auto model = MakeWorldModel({{plate, true}, {body, false, mass}}, kVoxel);
      World world(model);
      StepInputs inputs = FreeInputs(*model);
      Vec3 way = RandomDirection(random);
      way.z() = -3.0 * std::abs(way.z()) - 1.0;  // steeply down
      const Pose X_WB0 = model->bodies[0].X_WB0;
      inputs.hand =
          HandTo(*model, 0, {X_WB0.q, Vec3(0, 0, 0.02) + throw_length * way.normalized()});
      // the goal stays above the plate's middle, so that the body cannot go round it
      inputs.hand.goal.X_WA.p.x() = inputs.hand.goal.X_WA.p.y() = 0;
      double deepest = 0;
      for (int frame = 0; frame < 1500; ++frame) {
        world.Step(inputs);
        const Pose& X_WB = world.state(0).X_WB;
        ASSERT_GT(X_WB.p.z(), 0.0) << "through the plate in frame " << frame;
        deepest = std::max(deepest, DeepestVertex(solid, body, X_WB0, X_WB));
      }
      // 5 m at 800 N/m are 4 kN: no hand; layer 2 holds what a hand can do (half a voxel)
      if (throw_length < 1.0) {
        EXPECT_LE(deepest, 4.0 * kVoxel) << "mass " << mass;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Voxels, NoTunnelling, ::testing::Values(1.0, 3.0));

// Nothing holds them back but contact with the plate, which is thinner than a voxel.
TEST(NoTunnelling, FreeBallsAndCylindersDoNotGoThroughAThinPlate) {
  kHapticThread.Enter();
  std::mt19937_64 random(9);
  for (const double thickness : {0.3, 1.0}) {
    for (const double mass : {0.02, 2.0}) {
      for (const bool ball : {true, false}) {
        for (int trial = 0; trial < 3; ++trial) {
          const Quat q = ball ? RandomRotation(random) : RotationBy(Vec3(0, 0.37 * trial, 0));
          const TriangleMesh body =
              ball ? testing::Sphere(0.01, 4) : testing::Cylinder(0.01, 0.02, 64);
          const auto model =
              MakeWorldModel({{At(Box(Vec3(0.08, 0.08, thickness * kVoxel)), Vec3::Zero()), true},
                              {At(body, Vec3(0, 0, 0.0135 + 0.0002 * trial), q), false, mass}},
                             kVoxel);
          World world(model);
          StepInputs inputs = FreeInputs(*model);
          // a body that another peer has moved so far goes on at its twist
          inputs.instances[0].drive = BodyDrive::kMirrored;
          inputs.instances[0].mirror_WB = model->bodies[0].X_WB0;
          world.Step(inputs);
          inputs.instances[0].drive = BodyDrive::kSimulated;
          inputs.instances[0].begin_V_WB.v = Vec3(0.02, 0.01, -0.5);
          double lowest = 1;
          for (int frame = 0; frame < 400; ++frame) {
            world.Step(inputs);
            lowest = std::min(lowest, world.state(0).X_WB.p.z());
          }
          // its lowest place stays above the plate's other side
          EXPECT_GT(lowest, 0.01 - 0.5 * thickness * kVoxel)
              << thickness << " voxels, " << mass << " kg, " << (ball ? "ball" : "cylinder");
          EXPECT_GT(world.state(0).V_WB.v.z(), 0);
        }
      }
    }
  }
}

// A hand's goal goes through a thin plate, or a sheet without thickness, at 5 m/s and waits beyond
// it; the body, turned at random, stays on its side. More tries:
// `tandem bench fidelity --only sheets`.
TEST(Sheets, FastGoalDoesNotPullABodyThroughASheet) {
  kHapticThread.Enter();
  constexpr double kThin = 0.3 * kVoxel;
  constexpr double kSpeed = 5;  // m/s
  const TriangleMesh body = At(Box(Vec3(0.016, 0.012, 0.010)), Vec3(0, 0, 0.04));
  for (const TriangleMesh& sheet : {Box(Vec3(0.2, 0.2, kThin)), testing::Sheet(0.2)}) {
    const auto model = MakeWorldModel({{sheet, true}, {body}}, kVoxel);
    std::mt19937_64 random(7);
    for (int trial = 0; trial < 100; ++trial) {
      World world(model);
      StepInputs inputs = FreeInputs(*model);
      const Quat q = RandomRotation(random);
      const Vec3 from(0, 0, 0.014 + 0.004 * testing::Uniform(random, 0, 1));
      Vec3 way = RandomDirection(random);
      way.z() = -std::abs(way.z()) - 0.3;
      way.normalize();
      world.Place(0, {q, from});
      for (int frame = 0; frame < 300; ++frame) {
        const double gone = std::min(0.04, kSpeed * kFrame * frame);
        inputs.hand = HandTo(*model, 0, {q, from + gone * way});
        world.Step(inputs);
        ASSERT_GT(world.state(0).X_WB.p.z(), 0.0) << "trial " << trial << ", frame " << frame;
      }
    }
  }
}

class ExactSurfaces : public ::testing::TestWithParam<ContactModel> {};

// A hand presses with 16 N (20 mm of stretch) from random directions. Force begins before a vertex
// of the exact body is in the exact plate: in refined contact at its layer 1, in plain contact at
// layer 2, the least that the paper says it of (§3.2). Then refined contact holds it to half a
// voxel; plain contact pushes a corner along the corner's own normal, and lets two of twelve go a
// voxel in.
TEST_P(ExactSurfaces, ArePushedApartBeforeTheyMeetAtTheDefaultLayer) {
  kHapticThread.Enter();
  std::mt19937_64 random(8);
  const TriangleMesh plate = At(Box(Vec3(0.06, 0.06, 0.008)), Vec3(0, 0, -0.004));
  const ExactSurface solid(plate);
  for (int trial = 0; trial < 12; ++trial) {
    const TriangleMesh body =
        At(Box(Vec3(0.016, 0.012, 0.010)), Vec3(0, 0, 0.02), RandomRotation(random));
    const auto model = MakeWorldModel({{plate, true}, {body}}, kVoxel, GetParam());
    World world(model);
    ASSERT_EQ(world.pair(0).clearance().layers, GetParam() == ContactModel::kPlain ? 2 : 1);
    StepInputs inputs = FreeInputs(*model);
    const Pose X_WB0 = model->bodies[0].X_WB0;
    double deepest = 0;
    int contact_frames = 0;
    for (int frame = 0; frame < 1500; ++frame) {
      // down at 0.1 m/s to 10 mm below the face, turning slowly
      const double depth = std::min(0.03, 1e-4 * frame);
      const Quat turned = RotationBy(Vec3(0, 0, 1e-3 * frame)) * X_WB0.q;
      inputs.hand = HandTo(*model, 0, {turned, Vec3(0, 0, 0.02 - depth)});
      contact_frames += world.Step(inputs).pushing_points > 0 ? 1 : 0;
      deepest = std::max(deepest, DeepestVertex(solid, body, X_WB0, world.state(0).X_WB));
      if (contact_frames < 2) {
        EXPECT_EQ(deepest, 0) << "trial " << trial;
      }
    }
    EXPECT_GT(contact_frames, 500);
    const double most = GetParam() == ContactModel::kPlain ? 1.5 : 0.5;
    EXPECT_LE(deepest, most * kVoxel) << "trial " << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(Models, ExactSurfaces,
                         ::testing::Values(ContactModel::kRefined, ContactModel::kPlain));

// Others hold a shared body in two places, and both instances are drawn into the wall as yielding
// mirrors are: neither gets into it.
TEST(World, BothInstancesOfASeparatedBodyStopAtTheFixture) {
  kHapticThread.Enter();
  const TriangleMesh wall = At(Box(Vec3(0.01, 0.12, 0.06)), Vec3(-0.005, 0, 0));
  const TriangleMesh cube = At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0.02, 0, 0));
  const TriangleMesh elsewhere = At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0.2, 0, 0));
  const ExactSurface solid(wall);
  auto model =
      std::make_shared<WorldModel>(*MakeWorldModel({{wall, true}, {cube}, {elsewhere}}, kVoxel));
  model->scene.bodies[1].shared = true;
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[1].drive = BodyDrive::kParked;
  const double mass = model->bodies[0].inertia.mass;
  const Mat3 per_mass = model->bodies[0].inertia.I_B / mass;
  const Pose& X_WB0 = model->bodies[0].X_WB0;
  constexpr InstanceIndex kSecondInstance = 2;
  ASSERT_EQ(world.shape_of(kSecondInstance), 0U);
  for (const InstanceIndex instance : {InstanceIndex{0}, kSecondInstance}) {
    StepInputs::InstanceInput& input = inputs.instances[instance];
    input.drive = BodyDrive::kCompliant;
    input.pull = {400, 20, 400 * per_mass, 20 * per_mass};
    input.mirror_WB = {X_WB0.q, Vec3(-0.005, instance == 0 ? 0.03 : -0.03, 0)};
  }
  double deepest = 0;
  for (int frame = 0; frame < 1500; ++frame) {
    world.Step(inputs);
    for (const RigidState* state : {&world.state(0), &world.state(kSecondInstance)}) {
      deepest = std::max(deepest, DeepestVertex(solid, cube, X_WB0, state->X_WB));
    }
  }
  EXPECT_LE(deepest, 0.5 * kVoxel);
  EXPECT_NEAR(world.state(0).X_WB.p.y(), 0.03, 2e-3);  // they are drawn there along the wall
  EXPECT_NEAR(world.state(kSecondInstance).X_WB.p.y(), -0.03, 2e-3);
  EXPECT_NEAR(world.state(0).X_WB.p.x(), world.state(kSecondInstance).X_WB.p.x(), 1e-4);
}

}  // namespace
}  // namespace tandem
