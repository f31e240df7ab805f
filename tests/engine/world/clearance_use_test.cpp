// A clearance that changes while a hand holds a part has two uses (paper §3.2): a wide one plans a
// way that keeps its distance, and a shrinking one tells how tight a fit is.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/check.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/world/world.h"
#include "engine/world/world_of_meshes.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::kVoxel;
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

constexpr double kRange = 6;  // voxels of clearance

/// A part in hand between fixed boxes.
struct Held {
  Held(const std::vector<TriangleMesh>& fixed_W, const TriangleMesh& part_W) {
    std::vector<MeshBody> bodies;
    for (const TriangleMesh& mesh_W : fixed_W) bodies.push_back({mesh_W, true});
    bodies.push_back({part_W});
    auto made = WorldOfMeshes(bodies, kVoxel, ContactModel::kRefined, kRange);
    TANDEM_CHECK(made.has_value());
    model = *made;
    world = std::make_unique<World>(model);
    inputs = FreeInputs(*model);
    first = model->bodies[0].X_WB0;
    inputs.hand = HandTo(*model, 0, first);
  }
  /// Lets force begin that far from surfaces, voxels, and waits until it does.
  void BeginAt(double reach) {
    inputs.clearance.displacement = (kRefinedClearance - reach) * kVoxel;
    for (int frame = 0; frame < 1000; ++frame) Step();
  }
  void Pull(const Vec3& voxels) { inputs.hand.goal.X_WA.p = first.p + voxels * kVoxel; }
  void Step() {
    const Vec3 before = force;
    force = world->Step(inputs).hand_B_W.f;
    most_step = std::max(most_step, (force - before).norm());
    touched = touched || !world->pair(0).contacts().empty();
  }
  /// Returns the part's way from its first place, voxels.
  Vec3 way() const { return (world->state(0).X_WB.p - first.p) / kVoxel; }

  std::shared_ptr<const WorldModel> model;
  std::unique_ptr<World> world;
  StepInputs inputs;
  Pose first;
  Vec3 force = Vec3::Zero();
  double most_step = 0;  // N, from frame to frame
  bool touched = false;
};

/// Returns a slab whose upper face is at a height, voxels, or its lower one.
TriangleMesh Slab(double height, bool above) {
  return At(Box(kVoxel * Vec3(120, 40, 10)), kVoxel * Vec3(0, 0, height + (above ? 5 : -5)));
}

// The hand leans the part on the floor of a corridor, and moves it along. The part is eight voxels
// high and stands at first eight voxels above the floor.
TEST(Clearance, KeepsTheSetDistanceFromCorridorWalls) {
  kHapticThread.Enter();
  Held held({Slab(-12, false), Slab(12, true)}, Box(kVoxel * Vec3(8, 8, 8)));
  for (const double reach : {kRefinedClearance, 1.0, 2.5, 5.0}) {
    held.Pull({0, 0, 0});
    held.BeginAt(reach);
    double least = 1e9;
    for (int frame = 0; frame < 2500; ++frame) {
      held.Pull({20 * std::sin(0.002 * frame), 0, -8.5});
      held.Step();
      if (frame > 500) least = std::min(least, 8 + held.way().z());
    }
    // the hand's pull is a small part of a voxel of depth
    EXPECT_GT(least, reach - 0.15) << reach;
    EXPECT_LT(least, reach + 0.05) << reach;
  }
}

// Where both walls are nearer than force may begin, they leave the part between them.
TEST(Clearance, CentresAPartInANarrowerCorridor) {
  kHapticThread.Enter();
  Held held({Slab(-6, false), Slab(6, true)}, Box(kVoxel * Vec3(8, 8, 8)));
  held.BeginAt(5.0);
  EXPECT_NEAR(held.way().norm(), 0, 0.1);
  for (int frame = 0; frame < 2000; ++frame) {
    held.Pull({0.01 * frame, 0, 0});
    held.Step();
  }
  EXPECT_NEAR(held.way().x(), 20, 0.5);
  EXPECT_NEAR(held.way().z(), 0, 0.1);
}

// A part of eight voxels goes down between walls that leave it a play of 0.7, 1.6 and 3.1 voxels
// to either side. The greatest clearance at which nothing touches is that play.
TEST(Clearance, ShrinkingUntilAPartPassesMeasuresTheFit) {
  kHapticThread.Enter();
  for (const double play : {0.7, 1.6, 3.1}) {
    const auto wall = [&](double side) {
      return At(Box(kVoxel * Vec3(20, 30, 20)), kVoxel * Vec3(side * (14 + play), 0, -20));
    };
    Held held({wall(-1), wall(1)}, Box(kVoxel * Vec3(8, 8, 8)));
    double reported = 0;
    for (double reach = 5.5; reach > 0.1 && reported == 0; reach -= 0.1) {
      held.Pull({0, 0, 0});
      held.BeginAt(reach);
      held.touched = false;
      for (int frame = 0; frame < 800 && !held.touched; ++frame) {
        held.Pull({0, 0, -0.02 * frame});
        held.Step();
      }
      if (!held.touched) reported = reach;
    }
    // the clearance falls by tenths, and beyond the fine band contact ends up to half a voxel
    // sooner
    EXPECT_LE(reported, play + 0.001) << play;
    EXPECT_GE(reported, play - 0.65) << play;
  }
}

// The hand feels a surface that comes at the pace of the change, and no more.
TEST(Clearance, FullRangeSweepDoesNotJerkTheHand) {
  kHapticThread.Enter();
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 3; ++trial) {
    const Quat turn = trial == 0 ? Quat::Identity() : RandomRotation(random);
    Held held({Transformed(Slab(-4, false), {turn, Vec3::Zero()})},
              Transformed(Box(kVoxel * Vec3(8, 6, 8)), {turn, Vec3::Zero()}));
    held.inputs.hand.goal.X_WA.p = held.first.p - turn * Vec3(0, 0, 1.5 * kVoxel);
    for (int frame = 0; frame < 1500; ++frame) held.Step();
    held.most_step = 0;
    for (const double reach : {5.9, 0.0, 3.0, kRefinedClearance}) held.BeginAt(reach);
    EXPECT_LE(held.most_step, 0.088);
    EXPECT_TRUE(held.touched);
  }
}

// No feature point within reach is left out, wherever the part stands and whatever it is told.
TEST(Clearance, FullRangeMissesNoContactAndAllocatesNothing) {
  kHapticThread.Enter();
  std::mt19937_64 random(7);
  Held held({Slab(-9, false), Slab(9, true),
             At(Box(kVoxel * Vec3(3, 3, 40)), kVoxel * Vec3(11, 0, 0), RandomRotation(random))},
            Sphere(5 * kVoxel, 3));
  const ClearanceBounds bounds = held.world->pair(0).clearance_bounds();
  EXPECT_NEAR(bounds.most_outward, (kRange - kRefinedClearance) * kVoxel, 1e-9);
  std::size_t unfound = 0;
  long allocations = 0;
  int touching = 0;
  for (int frame = 0; frame < 3000; ++frame) {
    if (frame % 150 == 0) {
      held.inputs.clearance.displacement =
          Uniform(random, -bounds.most_outward, bounds.most_inward);
      held.Pull({Uniform(random, -8, 12), Uniform(random, -6, 6), Uniform(random, -5, 5)});
      held.inputs.hand.goal.X_WA.q = RandomRotation(random);
    }
    const BodyMotion before{held.world->state(0).X_WB, {}};
    const testing::AllocationCounter counter;
    held.Step();
    allocations += counter.count();
    touching += held.world->pair(0).contacts().empty() ? 0 : 1;
    if (frame % 5 == 0) unfound += held.world->field_pair(0).CountUnfound(before, {});
  }
  EXPECT_EQ(unfound, 0U);
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(touching, 1000);
}

}  // namespace
}  // namespace tandem
