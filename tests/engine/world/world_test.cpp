#include "engine/world/world.h"

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"
#include "tests/support/untested_points.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::KineticEnergy;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::RunFrames;
using testing::Sphere;
using testing::Uniform;
using testing::UntestedPoints;

TEST(World, NothingMovesWithoutForce) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{At(Sphere(0.01, 2), Vec3(0, 0, 0.05))}}, kVoxel);
  World world(model);
  const StepInputs inputs = FreeInputs(*model);
  RunFrames(world, inputs, 100);
  EXPECT_EQ(world.state(0).X_WB.p, model->bodies[0].X_WB0.p);
}

// Pressed into a corner by a goal that stands still: what moves settles within a second, and from
// then on the most energy of a half second never rises. The plain model may leave a rocking of
// micrometres where a point lies on the border of two voxels, whose planes differ
// (docs/decisions/0004-contact-and-step.md).
TEST(World, EnergyNeverGrowsAtRest) {
  kHapticThread.Enter();
  std::mt19937_64 random(9);
  const TriangleMesh floor = At(Box(Vec3(0.08, 0.08, 0.01)), Vec3(0, 0, -0.005));
  const TriangleMesh wall = At(Box(Vec3(0.01, 0.08, 0.06)), Vec3(-0.03, 0, 0.03));
  for (int trial = 0; trial < 6; ++trial) {
    const TriangleMesh body =
        At(Box(Vec3(0.016, 0.012, 0.010)), Vec3(0, 0, 0.02), RandomRotation(random));
    const auto model = MakeWorldModel({{floor, true}, {wall, true}, {body}}, kVoxel);
    World world(model);
    StepInputs inputs = FreeInputs(*model);
    inputs.hand = HandTo(*model, 0, {model->bodies[0].X_WB0.q, Vec3(-0.03, 0.004, -0.006)});
    std::vector<double> half_second_peaks;
    for (int window = 0; window < 8; ++window) {
      double peak = 0;
      for (int frame = 0; frame < 500; ++frame) {
        world.Step(inputs);
        peak = std::max(peak, KineticEnergy(*model, 0, world.state(0)));
      }
      half_second_peaks.push_back(peak);
    }
    for (std::size_t i = 2; i < half_second_peaks.size(); ++i) {
      EXPECT_LE(half_second_peaks[i], 1.001 * half_second_peaks[i - 1] + 1e-12)
          << "trial " << trial << " half second " << i;
    }
    EXPECT_LT(half_second_peaks.back(), 5e-6) << "trial " << trial;  // J: 0.3 kg at 6 mm/s
  }
}

/// Returns the farthest that any corner goes in a frame, of 400, towards a goal.
double FarthestStep(const WorldModel& model, World& world, const Pose& goal) {
  StepInputs inputs = FreeInputs(model);
  inputs.hand = HandTo(model, 0, goal);
  const std::vector<Vec3> corners = testing::CornersOf(model, 0);
  double farthest = 0;
  for (int frame = 0; frame < 400; ++frame) {
    const Pose before = world.state(0).X_WB;
    world.Step(inputs);
    const Pose& after = world.state(0).X_WB;
    for (const Vec3& corner : corners) {
      farthest = std::max(farthest, (after * corner - before * corner).norm());
    }
  }
  return farthest;
}

// Every point of the shell travels half a voxel a frame at the most, rotation included (brute
// force).
TEST(World, NoPointTravelsMoreThanHalfAVoxelAFrameNearAnotherBody) {
  kHapticThread.Enter();
  // a plate close under the whole way
  const auto model = MakeWorldModel({{At(Box(Vec3(0.05, 0.01, 0.01)), Vec3(0, 0, 0))},
                                     {At(Box(Vec3(1.6, 1.0, 0.01)), Vec3(0.3, 0, -0.013)), true}},
                                    kVoxel);
  World world(model);
  const Pose goal{RotationBy(Vec3(0, 0, 2.5)), Vec3(0.5, -0.2, 0)};
  EXPECT_LE(FarthestStep(*model, world, goal), 0.5 * kVoxel * 1.000001);
}

TEST(World, NoPointTravelsMoreThanHalfAHyperchunkAFrameAnywhere) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{At(Box(Vec3(0.05, 0.01, 0.01)), Vec3(0, 0, 0))}}, kVoxel);
  World world(model);
  const double farthest =
      FarthestStep(*model, world, {RotationBy(Vec3(0.5, 2.5, 1.0)), Vec3(0.5, -0.2, 0.1)});
  EXPECT_LE(farthest, 32.0 * kVoxel * 1.000001);
  EXPECT_GT(farthest, kVoxel);  // nothing is near that could be met
}

// A turning body sweeps what its marks sweep, which stand out beyond its surface.
TEST(World, TestsEveryPointInContactWhileTheVoxmapsBodyTurns) {
  kHapticThread.Enter();
  std::mt19937_64 random(21);
  for (const ContactModel contact : {ContactModel::kPlain, ContactModel::kRefined}) {
    const auto model = MakeWorldModel(
        {{Box(Vec3(0.02, 0.02, 0.02))}, {At(Box(Vec3(0.015, 0.012, 0.009)), Vec3(0, 0, 0.03))}},
        kVoxel, contact);
    World world(model);
    ASSERT_EQ(world.voxmap_of(0), 0U);
    StepInputs inputs = FreeInputs(*model);
    inputs.instances[0].drive = BodyDrive::kMirrored;
    std::size_t untested = 0;
    int touching = 0;
    Vec3 side = Vec3(0, 0, 0.01);
    for (int frame = 0; frame < 20000; ++frame) {
      // the large body is spun to and fro, the small one is led about it, near and far
      if (frame % 300 == 0) {
        inputs.instances[0].mirror_WB = {RandomRotation(random), 0.004 * RandomDirection(random)};
        side = Uniform(random, 0.01, 0.03) * RandomDirection(random);
      }
      inputs.hand = HandTo(*model, 1, {RandomRotation(random), side});
      const BodyMotion shell{world.state(1).X_WB, {}};
      const BodyMotion map{world.state(0).X_WB, {}};
      touching += world.Step(inputs).contact_points > 0 ? 1 : 0;
      if (contact == ContactModel::kRefined) {
        untested += world.field_pair(0).CountUnfound(shell, map);
        continue;
      }
      const ContactPair& pair = world.point_pair(0);
      untested += UntestedPoints(pair.blocks(), pair.voxmap(), pair.schedule());
    }
    EXPECT_EQ(untested, 0U);
    EXPECT_GT(touching, 2000);
  }
}

TEST(World, ParkedBodiesAreRigid) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0, 0, 0.04))},
                                     {At(Box(Vec3(0.03, 0.03, 0.02)), Vec3(0, 0, 0))}},
                                    kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[1].drive = BodyDrive::kParked;
  inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0, 0, 0)});
  RunFrames(world, inputs, 1000);
  EXPECT_EQ(world.state(1).X_WB.p, model->bodies[1].X_WB0.p);
  EXPECT_GT(world.state(0).X_WB.p.z(), 0.020);  // centres nearer than that would overlap
}

TEST(World, IsDeterministic) {
  kHapticThread.Enter();
  const TriangleMesh plate = At(Box(Vec3(0.06, 0.06, 0.008)), Vec3(0, 0, -0.004));
  const auto model =
      MakeWorldModel({{plate, true}, {At(Sphere(0.01, 3), Vec3(0, 0, 0.02))}}, kVoxel);
  World first(model);
  World second(model);
  StepInputs inputs = FreeInputs(*model);
  for (int frame = 0; frame < 1000; ++frame) {
    inputs.hand =
        HandTo(*model, 0, {RotationBy(Vec3(0, 1e-3 * frame, 0)), Vec3(1e-5 * frame, 0, 0.005)});
    first.Step(inputs);
    second.Step(inputs);
    ASSERT_EQ(first.state(0).X_WB.p, second.state(0).X_WB.p);
    ASSERT_EQ(first.state(0).X_WB.q.coeffs(), second.state(0).X_WB.q.coeffs());
  }
}

TEST(World, FramesAllocateNothing) {
  kHapticThread.Enter();
  const TriangleMesh plate = At(Box(Vec3(0.06, 0.06, 0.008)), Vec3(0, 0, -0.004));
  const auto model = MakeWorldModel({{plate, true},
                                     {At(Sphere(0.01, 3), Vec3(0, 0, 0.02))},
                                     {At(Sphere(0.008, 3), Vec3(0.02, 0, 0.02))}},
                                    kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[1].drive = BodyDrive::kMirrored;
  inputs.instances[1].mirror_WB.p = Vec3(0, 0, 0.02);
  inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0, 0, 0.0)});
  int loaded = 0;
  const testing::AllocationCounter counter;
  for (int frame = 0; frame < 1000; ++frame) loaded += world.Step(inputs).pushing_points;
  EXPECT_EQ(counter.count(), 0);
  EXPECT_GT(loaded, 0);
}

}  // namespace
}  // namespace tandem
