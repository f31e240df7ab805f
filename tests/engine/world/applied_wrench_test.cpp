// Tests the wrenches that a step reports, by the momentum that bodies gain.
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

/// A cube in a hand above a plate, and the contact that the step reports.
struct Impact {
  explicit Impact(ContactModel contact, double friction, bool second_moves)
      : model(MakeModel(contact, friction, second_moves)),
        world(model),
        inputs(FreeInputs(*model)) {
    inputs.ground_damping = 0.3;
  }
  static std::shared_ptr<const WorldModel> MakeModel(ContactModel contact, double friction,
                                                     bool second_moves) {
    const TriangleMesh plate = At(Box(Vec3(0.04, 0.04, 0.01)), Vec3(0, 0, -0.005));
    const TriangleMesh cube =
        At(Box(Vec3(0.012, 0.012, 0.012)), Vec3(0, 0, 0.012), RotationBy(Vec3(0.3, 0.2, 0.1)));
    auto made = std::make_shared<WorldModel>(
        *MakeWorldModel({{cube}, {plate, !second_moves, 0.5}}, kVoxel, contact));
    made->scene.friction = friction;
    // a free plate would fall out of reach
    made->scene.gravity_W = second_moves ? Vec3(0.3, 0, 0) : Vec3(0.3, 0, -9.81);
    return made;
  }
  /// Runs one frame. The oracle knows masses, velocities and all forces but contact's.
  void Step() {
    const RigidState before = world.state(0);
    const Twist other = model->bodies.size() > 1 ? world.state(1).V_WB : Twist{};
    const StepReport& report = world.Step(inputs);
    const Twist& after = world.state(0).V_WB;
    reported = report.contact_B_W;
    most_told = std::max(most_told, reported.f.norm());
    if ((report.flags & StepReport::kTravelLimited) != 0) return;
    const Inertia& inertia = model->bodies[0].inertia;
    const Vec3& g = model->scene.gravity_W;
    const Vec3 ground = -inputs.ground_damping * after.v;
    const Vec3 rest =
        inertia.mass * ((after.v - before.V_WB.v) / kFrame - g) - report.hand_B_W.f - ground;
    // a cube's inertia is alike about all axes, so there is no gyroscopic moment
    const Vec3 moment = inertia.I_B(0, 0) * (after.w - before.V_WB.w) / kFrame;
    worst =
        std::max({worst, (reported.f - rest).norm() / (1 + rest.norm()),
                  (reported.tau + report.hand_B_W.tau - moment).norm() / (0.001 + moment.norm())});
    ++checked;
    pressed += reported.f.norm() > 0 ? 1 : 0;
    if (model->bodies.size() == 1) return;
    // the other body loses what the held body gains
    const Inertia& others = model->bodies[1].inertia;
    const Vec3 on_other = others.mass * ((world.state(1).V_WB.v - other.v) / kFrame - g);
    worst = std::max(worst, (reported.f + on_other).norm() / (1 + on_other.norm()));
  }

  std::shared_ptr<const WorldModel> model;
  World world;
  StepInputs inputs;
  Wrench reported;
  double most_told = 0;  // N
  double worst = 0;      // part of the force or moment that the balance leaves
  int checked = 0;       // frames
  int pressed = 0;
};

class AppliedContact : public ::testing::TestWithParam<std::tuple<ContactModel, double, bool>> {};

// The hand throws the cube at a plate that is fixed, or free to move, and holds it there. The
// reported contact makes the change of momentum with all other forces, in the frames of the blow
// and at rest.
TEST_P(AppliedContact, BalancesTheChangeOfMomentum) {
  kHapticThread.Enter();
  const auto [contact, friction, second_moves] = GetParam();
  Impact blow(contact, friction, second_moves);
  const Quat& q = blow.model->bodies[0].X_WB0.q;
  // the throw at the free plate is gentle, or both bodies are held to the travel limit
  blow.inputs.hand = HandTo(*blow.model, 0, {q, Vec3(0.01, 0.002, second_moves ? 0.0 : -0.05)});
  for (int frame = 0; frame < 300; ++frame) blow.Step();
  // 0.3 kg at half a voxel a frame, stopped in one, are 150 N; the hand pulls with 60 N, and a
  // plate thrown back by gravity no faster
  EXPECT_LT(blow.most_told, 400);
  EXPECT_GT(blow.pressed, second_moves ? 5 : 50);
  blow.inputs.hand = HandTo(*blow.model, 0, {q, Vec3(0.002, 0, 0.004)});
  for (int frame = 0; frame < 500; ++frame) blow.Step();
  EXPECT_LT(blow.worst, 1e-9);
  EXPECT_GT(blow.checked, 300);
}

INSTANTIATE_TEST_SUITE_P(Cases, AppliedContact,
                         ::testing::Combine(::testing::Values(ContactModel::kRefined,
                                                              ContactModel::kPlain),
                                            ::testing::Values(0.0, 0.3), ::testing::Bool()));

/// A cube in a hand, that presses on a free block of three times its side far off the block's
/// centre. A cube's inertia is alike about all axes, so there is no gyroscopic moment.
struct OffCentrePush {
  explicit OffCentrePush(ContactModel contact, double friction)
      : model(MakeModel(contact, friction)), world(model), inputs(FreeInputs(*model)) {}
  static std::shared_ptr<const WorldModel> MakeModel(ContactModel contact, double friction) {
    const TriangleMesh block = At(Box(Vec3(0.036, 0.036, 0.036)), Vec3(0, 0, -0.018));
    const TriangleMesh cube = At(Box(Vec3(0.012, 0.012, 0.012)), Vec3(0.013, 0.008, 0.012),
                                 RotationBy(Vec3(0.3, 0.2, 0.1)));
    auto made = std::make_shared<WorldModel>(
        *MakeWorldModel({{cube, false, 0.3}, {block, false, 0.5}}, kVoxel, contact));
    made->scene.friction = friction;
    made->scene.gravity_W = Vec3(0.3, 0, 0);  // a free block would fall out of reach
    return made;
  }
  /// Runs a frame. It compares what contact gave the block, about the block's centre, by the
  /// block's own motion, with what the cube reports of contact, carried there with its sign turned.
  void Step() {
    const RigidState cube = world.state(0);
    const RigidState block = world.state(1);
    const StepReport& report = world.Step(inputs);
    if ((report.flags & StepReport::kTravelLimited) != 0) return;
    const Inertia& inertia = model->bodies[1].inertia;
    const Twist& after = world.state(1).V_WB;
    const Vec3 force = inertia.mass * ((after.v - block.V_WB.v) / kFrame - model->scene.gravity_W);
    const Vec3 moment = inertia.I_B(0, 0) * (after.w - block.V_WB.w) / kFrame;
    const Wrench& reported = report.contact_B_W;
    const Vec3 arm = cube.X_WB.p - block.X_WB.p;
    const Vec3 carried = -(reported.tau + arm.cross(reported.f));
    worst_force = std::max(worst_force, (reported.f + force).norm() / (1 + force.norm()));
    worst_moment = std::max(worst_moment, (carried - moment).norm() / (0.01 + moment.norm()));
    most_moment = std::max(most_moment, moment.norm());
    pressed += reported.f.norm() > 0 ? 1 : 0;
  }

  std::shared_ptr<const WorldModel> model;
  World world;
  StepInputs inputs;
  double worst_force = 0;  // part of the force that the balance leaves
  double worst_moment = 0;
  double most_moment = 0;  // N m
  int pressed = 0;         // frames
};

class AppliedContactOffCentre : public ::testing::TestWithParam<std::tuple<ContactModel, double>> {
};

// The block turns away under the push, which the cube's step must have foreseen.
TEST_P(AppliedContactOffCentre, GivesTheOtherBodyTheOppositeForceAndMoment) {
  kHapticThread.Enter();
  const auto [contact, friction] = GetParam();
  OffCentrePush push(contact, friction);
  const Quat& q = push.model->bodies[0].X_WB0.q;
  for (int frame = 0; frame < 800; ++frame) {
    // at 0.05 m/s, so that nothing is held to the travel limit
    push.inputs.hand = HandTo(*push.model, 0, {q, Vec3(0.013, 0.008, 0.012 - 5e-5 * frame)});
    push.Step();
  }
  EXPECT_GT(push.pressed, 20);
  EXPECT_GT(push.most_moment, 0.01);
  EXPECT_GT(push.world.state(1).V_WB.w.norm(), 0.1);
  EXPECT_LT(push.worst_force, 1e-9);
  EXPECT_LT(push.worst_moment, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Cases, AppliedContactOffCentre,
                         ::testing::Combine(::testing::Values(ContactModel::kRefined,
                                                              ContactModel::kPlain),
                                            ::testing::Values(0.0, 0.3)));

// At rest the plate bears what the hand presses with and the weight, in each frame.
TEST(World, ReportsThePressingForceOfARestingPart) {
  kHapticThread.Enter();
  Impact blow(ContactModel::kRefined, 0.3, false);
  const Quat level = Quat::Identity();
  blow.inputs.hand = HandTo(*blow.model, 0, {level, Vec3(0, 0, 0.0055)});
  for (int frame = 0; frame < 3000; ++frame) blow.Step();
  const double pressed =
      blow.inputs.hand.gains.stiffness * (blow.world.state(0).X_WB.p.z() - 0.0055);
  EXPECT_GT(pressed, 0.1);
  for (int frame = 0; frame < 500; ++frame) {
    blow.Step();
    ASSERT_NEAR(blow.reported.f.z(), 0.3 * 9.81 + pressed, 0.01 * pressed) << frame;
  }
}

// The body gets what the hand gives: with nothing else acting, force times time is momentum.
TEST(World, ReportsTheAppliedHandForceExactly) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0, 0, 0))}}, kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0.002, 0.001, 0)});
  for (int frame = 0; frame < 50; ++frame) {
    const Vec3 before = world.state(0).V_WB.v;
    const StepReport report = world.Step(inputs);
    const Vec3 momentum = model->bodies[0].inertia.mass * (world.state(0).V_WB.v - before);
    if ((report.flags & StepReport::kTravelLimited) == 0) {
      EXPECT_NEAR((momentum - kFrame * report.hand_B_W.f).norm(), 0.0, 1e-12);
    }
  }
}

}  // namespace
}  // namespace tandem
