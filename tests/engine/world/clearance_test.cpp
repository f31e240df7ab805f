#include "engine/contact/pair/clearance.h"

#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "engine/world/world.h"
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
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RandomRotation;
using testing::UntestedPoints;

/// A box that a hand presses onto a plate, both turned; and one beside it that nobody holds.
struct Pressed {
  explicit Pressed(ContactModel contact, const Quat& turn = Quat::Identity())
      : model(MakeWorldModel(
            {{Transformed(Box(Vec3(0.08, 0.08, 0.01)), {turn, turn * Vec3(0, 0, -0.005)}), true},
             {Transformed(Box(Vec3(0.016, 0.012, 0.010)), {turn, turn * Vec3(0, 0, 0.010)})},
             {Transformed(Box(Vec3(0.010, 0.010, 0.010)), {turn, turn * Vec3(0.03, 0, 0.010)})}},
            kVoxel, contact)),
        world(model),
        inputs(FreeInputs(*model)),
        up(turn * Vec3::UnitZ()) {
    inputs.hand = HandTo(*model, 0, {model->bodies[0].X_WB0.q, -0.001 * up});
  }
  void Run(int frames) {
    for (int i = 0; i < frames; ++i) {
      const Vec3 f = force;
      force = world.Step(inputs).hand_B_W.f;
      most_step = std::max(most_step, (force - f).norm());
      pressing += world.pair(0).contacts().empty() ? 0 : 1;
    }
  }
  double height() const { return up.dot(world.state(0).X_WB.p); }

  std::shared_ptr<const WorldModel> model;
  World world;
  StepInputs inputs;
  Vec3 up;
  Vec3 force = Vec3::Zero();
  double most_step = 0;  // N, from frame to frame
  int pressing = 0;      // frames
};

/// Counts the points in contact that a frame did not test, of a pair; `before`: where bodies stood.
std::size_t Untested(const World& world, std::size_t number,
                     const std::vector<BodyMotion>& before) {
  if (world.model().scene.contact == ContactModel::kRefined) {
    const InstanceIndex map = world.voxmap_of(number);
    return world.field_pair(number).CountUnfound(before[world.shell_of(number)],
                                                 map == kFixture ? BodyMotion{} : before[map]);
  }
  const ContactPair& pair = world.point_pair(number);
  if (pair.test_demand().bound > 0.5 * kVoxel) return 0;  // far: nothing is tested
  return UntestedPoints(pair.blocks(), pair.voxmap(), pair.schedule());
}

// Returns by how much a pressed box stands higher, voxels.
double RisenBy(Pressed& pressed, int layer, double displacement_voxels) {
  const double before = pressed.height();
  pressed.inputs.clearance = {layer, displacement_voxels * kVoxel};
  pressed.Run(1500);
  return (pressed.height() - before) / kVoxel;
}

// A displacement moves the surface itself: a box on a plate stands higher by just as much.
TEST(Clearance, DisplacementMovesTheOnsetOfRefinedContact) {
  kHapticThread.Enter();
  std::mt19937_64 random(2);
  for (const Quat& turn : {Quat::Identity(), RandomRotation(random)}) {
    Pressed pressed(ContactModel::kRefined, turn);
    pressed.Run(1000);
    const int layer = StepInputs::HandClearance::kSceneLayer;
    EXPECT_NEAR(RisenBy(pressed, layer, -0.7), 0.7, 0.05);
    EXPECT_NEAR(RisenBy(pressed, layer, 0.3), -1.0, 0.05);
    EXPECT_NEAR(RisenBy(pressed, 1, 0.0), 0.3, 0.05);
    EXPECT_NEAR(RisenBy(pressed, 2, 0.3), 0.7, 0.05);
  }
}

// Places by voxels are right to a voxel.
TEST(Clearance, ForceLayerMovesTheOnsetOfPlainContact) {
  kHapticThread.Enter();
  Pressed pressed(ContactModel::kPlain);
  pressed.Run(1000);
  EXPECT_NEAR(RisenBy(pressed, 5, 0), 3.0, 1.0);
  EXPECT_NEAR(RisenBy(pressed, 0, 0), -5.0, 1.0);
  EXPECT_NEAR(RisenBy(pressed, 2, 0), 2.0, 1.0);
}

// Spring and damper feel a body that is moved at the pace of the change, and no more.
TEST(Clearance, ChangeDoesNotJerkTheHand) {
  kHapticThread.Enter();
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 4; ++trial) {
    Pressed pressed(ContactModel::kRefined, trial == 0 ? Quat::Identity() : RandomRotation(random));
    pressed.Run(1500);
    const CouplingGains& gains = pressed.inputs.hand.gains;
    const double felt = (gains.stiffness * kFrame + gains.damping) * kClearancePace;
    for (const auto& [layer, voxels] :
         {std::pair(5, 0.0), std::pair(5, -1.0), std::pair(2, 1.0), std::pair(1, 0.0)}) {
      pressed.most_step = 0;
      pressed.pressing = 0;
      pressed.inputs.clearance = {layer, voxels * kVoxel};
      pressed.Run(800);
      EXPECT_LE(pressed.most_step, felt) << "trial " << trial << ", layer " << layer;
      EXPECT_EQ(pressed.pressing, 800);
    }
  }
}

// The body stands still while the layer goes from the least to the most: in no frame does the
// force rise by more than all points' springs give for what the layer has grown.
TEST(Clearance, PlainForcesGrowWithoutAStepFromLayerToLayer) {
  kHapticThread.Enter();
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 8; ++trial) {
    Pressed pressed(ContactModel::kPlain, RandomRotation(random));
    LinearizedForce before;
    bool first = true;
    int loaded = 0;
    const BodyModel& body = pressed.model->bodies[0];
    const Voxmap& map = pressed.model->fixture;
    ContactPair pair(body.points, map, {Quat::Identity(), map.p_WVo()}, 0, {.force_layer = 0},
                     {1e4, 0});
    Pose X_WB = body.X_WB0;
    X_WB.p -= 4 * kVoxel * pressed.up;  // a voxel above the plate
    constexpr double kStep = 0.01;
    for (double layers = 0; layers <= 4; layers += kStep) {
      pair.SetClearance({layers, 0});
      LinearizedForce load;
      LinearizedForce on_map;
      const PairReport report = pair.Collide({X_WB, {}}, {}, load, on_map);
      loaded += report.pushing_points;
      const double growth = (load.force - before.force).tail<3>().norm();
      // stiffness grows with depth, up to three voxels
      double most = 0;
      for (const Contact& contact : pair.contacts()) {
        most += ContactStiffness(1e4, std::min(contact.depth, 2.999 * kVoxel), kVoxel) * kStep *
                kVoxel * contact.nhat_V.lpNorm<1>();
      }
      if (!first) {
        ASSERT_LE(growth, most * 1.0001 + 1e-9) << "at layer " << layers;
      }
      first = false;
      before = load;
    }
    EXPECT_GT(loaded, 1000);
  }
}

TEST(Clearance, AppliesToTheHeldBodyUntilRelease) {
  kHapticThread.Enter();
  Pressed pressed(ContactModel::kRefined);
  pressed.inputs.clearance = {2, -0.5 * kVoxel};
  pressed.Run(400);
  const double scenes = pressed.model->scene.force_layer;
  for (std::size_t p = 0; p < pressed.world.pair_count(); ++p) {
    const bool in_hand = pressed.world.shell_of(p) == 0 || pressed.world.voxmap_of(p) == 0;
    const Clearance want = in_hand ? Clearance{2, -0.5 * kVoxel} : Clearance{scenes, 0};
    EXPECT_EQ(pressed.world.pair(p).clearance(), want) << p;
  }
  pressed.inputs.hand.body = -1;
  pressed.Run(400);
  for (std::size_t p = 0; p < pressed.world.pair_count(); ++p) {
    EXPECT_EQ(pressed.world.pair(p).clearance(), (Clearance{scenes, 0})) << p;
  }
}

TEST(Clearance, StaysWithinTheFieldsRange) {
  kHapticThread.Enter();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Pressed plain(ContactModel::kPlain);
  const int most = plain.model->fixture.range() - kWarningQueues;
  plain.inputs.clearance = {1000, 1.0};
  plain.Run(1000);
  EXPECT_EQ(plain.world.pair(0).clearance(), (Clearance{static_cast<double>(most), kVoxel}));
  plain.inputs.clearance = {-7, nan};
  plain.Run(1000);
  EXPECT_EQ(plain.world.pair(0).clearance(), (Clearance{0, 0}));
  Pressed refined(ContactModel::kRefined);
  refined.inputs.clearance = {0, -1.0};
  refined.Run(1000);
  EXPECT_EQ(refined.world.pair(0).clearance(), (Clearance{1, -1.05 * kVoxel}));
}

TEST(Clearance, ChangeMissesNoContactAndAllocatesNothing) {
  kHapticThread.Enter();
  std::mt19937_64 random(5);
  for (const ContactModel contact : {ContactModel::kPlain, ContactModel::kRefined}) {
    Pressed pressed(contact);
    std::size_t untested = 0;
    int touching = 0;
    long allocations = 0;
    for (int frame = 0; frame < 4000; ++frame) {
      if (frame % 40 == 0) {
        pressed.inputs.clearance = {static_cast<int>(random() % 7),
                                    testing::Uniform(random, -1.0, 1.0) * kVoxel};
        pressed.inputs.hand.goal.X_WA = {RandomRotation(random),
                                         Vec3(testing::Uniform(random, -0.01, 0.03), 0, 0)};
      }
      std::vector<BodyMotion> before;
      for (std::size_t b = 0; b < 2; ++b) before.push_back({pressed.world.state(b).X_WB, {}});
      const testing::AllocationCounter counter;
      touching += pressed.world.Step(pressed.inputs).contact_points > 0 ? 1 : 0;
      allocations += counter.count();
      for (std::size_t p = 0; p < 2; ++p) untested += Untested(pressed.world, p, before);
    }
    EXPECT_EQ(untested, 0U);
    EXPECT_GT(touching, 1000);
    EXPECT_EQ(allocations, 0);
  }
}

}  // namespace
}  // namespace tandem
