#include "engine/world/world.h"

#include <gtest/gtest.h>

#include "engine/geometry/exact_surface.h"
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
using testing::Sphere;
using testing::TestBody;
using testing::Uniform;
using testing::UntestedPoints;

/// How deep the body's vertices are in a solid (m), by exact geometry.
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

// The goal is thrown through the plate in one frame, so that the hand pulls with all it has; the
// plate is one and three voxels thick. Whatever the direction, the body stays on its side and its
// exact surface out.
TEST_P(NoTunnelling, ABodyThrownAtAThinPlateStaysOnItsSide) {
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

// A hand presses with 16 N (20 mm of stretch) from random directions. Force begins before a vertex
// of the exact body is in the exact plate: in refined contact at its layer 1, in plain contact at
// layer 2, the least that the paper says it of (§3.2). Then refined contact holds it to half a
// voxel; plain contact pushes a corner along the corner's own normal, and lets two of twelve go a
// voxel in.
class ExactSurfaces : public ::testing::TestWithParam<ContactModel> {};

TEST_P(ExactSurfaces, ArePushedBeforeTheyMeetAtTheModelsOwnLayer) {
  kHapticThread.Enter();
  std::mt19937_64 random(8);
  const TriangleMesh plate = At(Box(Vec3(0.06, 0.06, 0.008)), Vec3(0, 0, -0.004));
  const ExactSurface solid(plate);
  for (int trial = 0; trial < 12; ++trial) {
    const TriangleMesh body =
        At(Box(Vec3(0.016, 0.012, 0.010)), Vec3(0, 0, 0.02), RandomRotation(random));
    const auto model = MakeWorldModel({{plate, true}, {body}}, kVoxel, GetParam());
    World world(model);
    ASSERT_EQ(world.pair(0).schedule().force_layer(), GetParam() == ContactModel::kPlain ? 2 : 1);
    StepInputs inputs = FreeInputs(*model);
    const Pose X_WB0 = model->bodies[0].X_WB0;
    double deepest = 0;
    int contact_frames = 0;
    for (int frame = 0; frame < 1500; ++frame) {
      // down at 0.1 m/s to 10 mm below the face, turning slowly
      const double depth = std::min(0.03, 1e-4 * frame);
      const Quat turned = RotationBy(Vec3(0, 0, 1e-3 * frame)) * X_WB0.q;
      inputs.hand = HandTo(*model, 0, {turned, Vec3(0, 0, 0.02 - depth)});
      contact_frames += world.Step(inputs).loaded_points > 0 ? 1 : 0;
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

/// A cube in a hand above a plate, and what it is told of contact.
struct Blow {
  explicit Blow(ContactModel contact, double friction, bool second_moves)
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
  /// One frame. The oracle knows masses, velocities and all forces but contact's.
  void Step() {
    const RigidState before = world.state(0);
    const Twist other = model->bodies.size() > 1 ? world.state(1).V_WB : Twist{};
    const StepReport& report = world.Step(inputs);
    const Twist& after = world.state(0).V_WB;
    told = report.contact_B_W;
    most_told = std::max(most_told, told.f.norm());
    if ((report.flags & StepReport::kTravelLimited) != 0) return;
    const Inertia& inertia = model->bodies[0].inertia;
    const Vec3& g = model->scene.gravity_W;
    const Vec3 ground = -inputs.ground_damping * after.v;
    const Vec3 rest =
        inertia.mass * ((after.v - before.V_WB.v) / kFrame - g) - report.hand_B_W.f - ground;
    // a cube's inertia is alike about all axes, so there is no gyroscopic moment
    const Vec3 moment = inertia.I_B(0, 0) * (after.w - before.V_WB.w) / kFrame;
    worst = std::max({worst, (told.f - rest).norm() / (1 + rest.norm()),
                      (told.tau + report.hand_B_W.tau - moment).norm() / (0.001 + moment.norm())});
    ++checked;
    pressed += told.f.norm() > 0 ? 1 : 0;
    if (model->bodies.size() == 1) return;
    // what the held body gains the other one loses
    const Inertia& others = model->bodies[1].inertia;
    const Vec3 on_other = others.mass * ((world.state(1).V_WB.v - other.v) / kFrame - g);
    worst = std::max(worst, (told.f + on_other).norm() / (1 + on_other.norm()));
  }

  std::shared_ptr<const WorldModel> model;
  World world;
  StepInputs inputs;
  Wrench told;
  double most_told = 0;  // N
  double worst = 0;      // part of the force or moment that the balance leaves
  int checked = 0;       // frames
  int pressed = 0;
};

class AppliedContact : public ::testing::TestWithParam<std::tuple<ContactModel, double, bool>> {};

// The hand throws the cube at a plate that is fixed, or free to move, and holds it there. What is
// told of contact makes the change of momentum with all other forces, in the frames of the blow and
// at rest.
TEST_P(AppliedContact, BalancesTheChangeOfMomentum) {
  kHapticThread.Enter();
  const auto [contact, friction, second_moves] = GetParam();
  Blow blow(contact, friction, second_moves);
  const Quat& q = blow.model->bodies[0].X_WB0.q;
  // gently at the free one, or both are held to the travel limit
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

// At rest the plate bears what the hand presses with and the weight, in each frame.
TEST(World, TellsOfAPartAtRestTheForceThatItPressesWith) {
  kHapticThread.Enter();
  Blow blow(ContactModel::kRefined, 0.3, false);
  const Quat level = Quat::Identity();
  blow.inputs.hand = HandTo(*blow.model, 0, {level, Vec3(0, 0, 0.0055)});
  for (int frame = 0; frame < 3000; ++frame) blow.Step();
  const double pressed =
      blow.inputs.hand.gains.stiffness * (blow.world.state(0).X_WB.p.z() - 0.0055);
  EXPECT_GT(pressed, 0.1);
  for (int frame = 0; frame < 500; ++frame) {
    blow.Step();
    ASSERT_NEAR(blow.told.f.z(), 0.3 * 9.81 + pressed, 0.01 * pressed) << frame;
  }
}

TEST(World, NothingMovesWhereNothingPulls) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{At(Sphere(0.01, 2), Vec3(0, 0, 0.05))}}, kVoxel);
  World world(model);
  const StepInputs inputs = FreeInputs(*model);
  for (int frame = 0; frame < 100; ++frame) world.Step(inputs);
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

/// The farthest that any surface point goes in a frame, of 400, towards a goal.
double FarthestStep(const WorldModel& model, World& world, const Pose& goal) {
  StepInputs inputs = FreeInputs(model);
  inputs.hand = HandTo(model, 0, goal);
  const Pointshell& shell = model.bodies[0].points;
  double farthest = 0;
  for (int frame = 0; frame < 400; ++frame) {
    const Pose before = world.state(0).X_WB;
    world.Step(inputs);
    const Pose& after = world.state(0).X_WB;
    for (std::size_t i = 0; i < shell.size(); i += 7) {
      farthest = std::max(farthest, (after * shell.point(i) - before * shell.point(i)).norm());
    }
  }
  return farthest;
}

// Travel of every point of the shell, brute force: half a voxel a frame, rotation included.
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

// The other peer's part re-appears behind ours after an outage: its mirror must walk there, not
// jump.
TEST(World, AMirrorThatJumpsDoesNotTunnel) {
  kHapticThread.Enter();
  const TriangleMesh mine = At(Box(Vec3(0.04, 0.04, 0.003)), Vec3(0, 0, 0));
  const TriangleMesh theirs = At(Sphere(0.008, 3), Vec3(0, 0, 0.03));
  const auto model = MakeWorldModel({{mine}, {theirs}}, kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.hand = HandTo(*model, 0, Pose{});
  inputs.bodies[1].drive = BodyDrive::kMirrored;
  inputs.bodies[1].mirror_WB.p = Vec3(0, 0, -0.03);
  double largest_step = 0;
  bool touched = false;
  for (int frame = 0; frame < 600; ++frame) {
    const Vec3 before = world.state(1).X_WB.p;
    const StepReport report = world.Step(inputs);
    touched = report.loaded_points > 0 || touched;
    // where no voxel has a mark it may walk faster
    const bool near = report.tests.looked_up > 0;
    if (near) largest_step = std::max(largest_step, (world.state(1).X_WB.p - before).norm());
    // ours is pushed along: the mirror's centre never gets past our middle
    ASSERT_GT(world.state(1).X_WB.p.z(), world.state(0).X_WB.p.z()) << "frame " << frame;
  }
  EXPECT_TRUE(touched);
  EXPECT_LE(largest_step, 0.25 * kVoxel * 1.000001);  // half of the pair's half voxel
}

// What a turning body sweeps is what its marks sweep, which stand out beyond its surface.
TEST(World, TestsEveryPointInContactWhileTheVoxmapsBodyTurns) {
  kHapticThread.Enter();
  std::mt19937_64 random(21);
  for (const ContactModel contact : {ContactModel::kPlain, ContactModel::kRefined}) {
    const auto model = MakeWorldModel(
        {{Box(Vec3(0.02, 0.02, 0.02))}, {At(Box(Vec3(0.015, 0.012, 0.009)), Vec3(0, 0, 0.03))}},
        kVoxel, contact);
    World world(model);
    ASSERT_EQ(world.voxmap_of(0), 0);
    StepInputs inputs = FreeInputs(*model);
    inputs.bodies[0].drive = BodyDrive::kMirrored;
    std::size_t untested = 0;
    int touching = 0;
    Vec3 side = Vec3(0, 0, 0.01);
    for (int frame = 0; frame < 20000; ++frame) {
      // the large body is spun to and fro, the small one is led about it, near and far
      if (frame % 300 == 0) {
        inputs.bodies[0].mirror_WB = {RandomRotation(random), 0.004 * RandomDirection(random)};
        side = Uniform(random, 0.01, 0.03) * RandomDirection(random);
      }
      inputs.hand = HandTo(*model, 1, {RandomRotation(random), side});
      touching += world.Step(inputs).contact_points > 0 ? 1 : 0;
      const ContactPair& pair = world.pair(0);
      untested += UntestedPoints(pair.blocks(), pair.voxmap(), pair.schedule());
    }
    EXPECT_EQ(untested, 0U);
    EXPECT_GT(touching, 2000);
  }
}

// A mirror may come 60 mm in a frame; who takes it then takes no 60 m/s with it.
TEST(World, WhatWasMirroredBeginsAtRest) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{Box(Vec3(0.02, 0.02, 0.02))}}, 0.002);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.bodies[0].drive = BodyDrive::kMirrored;
  inputs.bodies[0].mirror_WB = model->bodies[0].X_WB0;
  inputs.bodies[0].mirror_WB.p.x() += 0.06;
  inputs.bodies[0].mirror_WB.q = RotationBy(Vec3(0, 0.2, 0)) * inputs.bodies[0].mirror_WB.q;
  world.Step(inputs);
  const Pose X_WB = world.state(0).X_WB;
  ASSERT_GT(world.state(0).V_WB.v.norm(), 10);
  inputs.bodies[0].drive = BodyDrive::kSimulated;
  inputs.hand = testing::HandTo(*model, 0, X_WB);
  EXPECT_LT(world.Step(inputs).hand_B_W.f.norm(), 1e-9);
  EXPECT_LT((world.state(0).X_WB.p - X_WB.p).norm(), 1e-12);
  // one that is moved by forces keeps its way
  inputs.hand.goal.X_WA.p.x() += 0.01;
  world.Step(inputs);
  EXPECT_GT(world.state(0).V_WB.v.x(), 0.01);
}

// A mirror that can meet nothing here follows its pose at once, as its own peer moves it.
TEST(World, AMirrorAloneFollowsItsPoseAtFreeSpeed) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel(
      {{At(Box(Vec3(0.2, 0.2, 0.01)), Vec3(0, 0, -0.2)), true}, {Sphere(0.01, 3)}}, kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.bodies[0].drive = BodyDrive::kMirrored;
  inputs.bodies[0].mirror_WB.p = Vec3(0.1, 0, 0);
  for (int frame = 0; frame < 5; ++frame) world.Step(inputs);
  EXPECT_LT((world.state(0).X_WB.p - Vec3(0.1, 0, 0)).norm(), 1e-9);
}

// Others hold a shared body in two places, and both instances are drawn into the wall as yielding
// mirrors are: neither gets into it.
TEST(World, BothInstancesOfAPartedBodyStopAtTheFixture) {
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
  inputs.bodies[1].drive = BodyDrive::kParked;
  StepInputs::BodyInput& input = inputs.bodies[0];
  const double mass = model->bodies[0].inertia.mass;
  const Mat3 per_mass = model->bodies[0].inertia.I_B / mass;
  input.drive = input.second_drive = BodyDrive::kYielding;
  input.pull = input.second_pull = {400, 20, 400 * per_mass, 20 * per_mass};
  input.parted = true;
  const Pose& X_WB0 = model->bodies[0].X_WB0;
  input.mirror_WB = {X_WB0.q, Vec3(-0.005, 0.03, 0)};
  input.second_WB = {X_WB0.q, Vec3(-0.005, -0.03, 0)};
  double deepest = 0;
  for (int frame = 0; frame < 1500; ++frame) {
    world.Step(inputs);
    for (const RigidState* state : {&world.state(0), &world.second_state(0)}) {
      deepest = std::max(deepest, DeepestVertex(solid, cube, X_WB0, state->X_WB));
    }
  }
  EXPECT_LE(deepest, 0.5 * kVoxel);
  EXPECT_NEAR(world.state(0).X_WB.p.y(), 0.03, 2e-3);  // where they are drawn along the wall
  EXPECT_NEAR(world.second_state(0).X_WB.p.y(), -0.03, 2e-3);
  EXPECT_NEAR(world.state(0).X_WB.p.x(), world.second_state(0).X_WB.p.x(), 1e-4);
}

TEST(World, ParkedBodiesStandAndPushBack) {
  kHapticThread.Enter();
  const auto model = MakeWorldModel({{At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0, 0, 0.04))},
                                     {At(Box(Vec3(0.03, 0.03, 0.02)), Vec3(0, 0, 0))}},
                                    kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.bodies[1].drive = BodyDrive::kParked;
  inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0, 0, 0)});
  for (int frame = 0; frame < 1000; ++frame) world.Step(inputs);
  EXPECT_EQ(world.state(1).X_WB.p, model->bodies[1].X_WB0.p);
  EXPECT_GT(world.state(0).X_WB.p.z(), 0.020);  // centres nearer than that would overlap
}

TEST(World, SameInputsGiveTheSameBits) {
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

TEST(World, AThousandFramesAllocateNothing) {
  kHapticThread.Enter();
  const TriangleMesh plate = At(Box(Vec3(0.06, 0.06, 0.008)), Vec3(0, 0, -0.004));
  const auto model = MakeWorldModel({{plate, true},
                                     {At(Sphere(0.01, 3), Vec3(0, 0, 0.02))},
                                     {At(Sphere(0.008, 3), Vec3(0.02, 0, 0.02))}},
                                    kVoxel);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.bodies[1].drive = BodyDrive::kMirrored;
  inputs.bodies[1].mirror_WB.p = Vec3(0, 0, 0.02);
  inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0, 0, 0.0)});
  int loaded = 0;
  const testing::AllocationCounter counter;
  for (int frame = 0; frame < 1000; ++frame) loaded += world.Step(inputs).loaded_points;
  EXPECT_EQ(counter.count(), 0);
  EXPECT_GT(loaded, 0);
}

// What the hand gives is what the body gets: with nothing else acting, force times time is
// momentum.
TEST(World, ReportsExactlyTheHandsForceThatTheBodyReceived) {
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
