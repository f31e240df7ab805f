// Tests Coulomb friction between bodies against the textbook: slopes, sliding blocks, spinning
// discs.
#include "engine/contact/pair/friction.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::KineticEnergy;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RandomRotation;
using testing::RunFrames;
using testing::Sphere;
using testing::TestBody;

constexpr double kGravity = 9.81;

std::shared_ptr<const WorldModel> WithFriction(const std::vector<TestBody>& bodies, double friction,
                                               const Vec3& gravity_W, ContactModel contact) {
  auto model = std::make_shared<WorldModel>(*MakeWorldModel(bodies, kVoxel, contact));
  model->scene.friction = friction;
  model->scene.gravity_W = gravity_W;
  return model;
}

/// A block on a slope along the x axis of `q_`, and how it goes down: a tilted plate, or a level
/// one under gravity that leans.
class Slope {
 public:
  Slope(double tangent, double friction, bool tilted, ContactModel contact = ContactModel::kRefined)
      : q_(RotationBy(Vec3(0, tilted ? std::atan(tangent) : 0.0, 0))),
        model_(WithFriction(
            {{At(Box(Vec3(0.8, 0.06, 0.006)), q_ * Vec3(0.35, 0, -0.003), q_), true},
             {At(Box(Vec3(0.03, 0.02, 0.008)), q_ * Vec3(0, 0, 0.004 + FirstGap(contact)), q_)}},
            friction, q_ * (RotationBy(Vec3(0, -std::atan(tangent), 0)) * Vec3(0, 0, -kGravity)),
            contact)),
        world_(model_),
        inputs_(FreeInputs(*model_)) {}

  void Run(int frames) {
    kHapticThread.Enter();
    RunFrames(world_, inputs_, frames);
  }
  double speed() const { return world_.state(0).V_WB.v.dot(q_ * Vec3::UnitX()); }
  /// Returns the way of its centre from where it stood: along the slope, across it, and off it.
  Vec3 moved() const {
    return q_.conjugate() * (world_.state(0).X_WB.p - model_->bodies[0].X_WB0.p);
  }

 private:
  /// Returns a gap just above where it will rest.
  static double FirstGap(ContactModel contact) {
    return (contact == ContactModel::kRefined ? 0.5 : 3.0) * kVoxel;
  }

  Quat q_;
  std::shared_ptr<const WorldModel> model_;
  World world_;
  StepInputs inputs_;
};

TEST(Friction, BlockBelowTheFrictionAngleOnlyCreeps) {
  for (const bool tilted : {false, true}) {
    for (const double tangent : {0.1, 0.3, 0.45}) {
      Slope slope(tangent, 0.5, tilted);
      slope.Run(500);
      const double from = slope.moved().x();
      slope.Run(1000);
      // creep in a second; its share of the creep's limit is the load's share of what friction can
      // hold
      const double creep = slope.moved().x() - from;
      EXPECT_NEAR(creep, kCreepSpeed * tangent / 0.5, 0.05 * kCreepSpeed) << tangent;
      EXPECT_LT(std::abs(slope.moved().y()), 0.01 * kVoxel) << tangent;
    }
  }
}

TEST(Friction, BlockAboveTheFrictionAngleHasTheAnalyticAcceleration) {
  for (const bool tilted : {false, true}) {
    for (const auto& [tangent, friction] :
         {std::pair(0.8, 0.5), std::pair(0.3, 0.2), std::pair(0.3, 0.0)}) {
      // not long: in contact no point goes faster than half a voxel a frame, 0.5 m/s
      Slope slope(tangent, friction, tilted);
      slope.Run(60);
      const double before = slope.speed();
      slope.Run(60);
      const double angle = std::atan(tangent);
      const double drive = kGravity * std::sin(angle);
      const double drag = friction * kGravity * std::cos(angle);
      // on a tilted plate the places of voxels, rounded to 4 micrometres, make a light block hop
      EXPECT_NEAR((slope.speed() - before) / 0.06, drive - drag,
                  1e-3 * drive + (tilted ? 0.08 : 0.02) * drag)
          << tangent << ", " << friction << ", " << tilted;
    }
  }
}

// The plain model's planes jump from voxel to voxel, so it holds on steeper slopes than it should.
// The test asks only that it does hold.
TEST(Friction, HoldsInThePlainModelToo) {
  Slope held(0.3, 0.5, false, ContactModel::kPlain);
  held.Run(500);
  const double from = held.moved().x();
  held.Run(1000);
  EXPECT_LT(std::abs(held.moved().x() - from), 0.2 * kVoxel);
}

// A hand has thrown a block along a plate. From frame to frame the block has less energy, stops
// after v^2 / (2 mu g), and then lies still.
TEST(Friction, ThrownBlockLosesEnergyAndStopsAtTheAnalyticDistance) {
  kHapticThread.Enter();
  constexpr double kMu = 0.3;
  const auto model = WithFriction({{At(Box(Vec3(0.5, 0.06, 0.006)), Vec3(0.2, 0, -0.003)), true},
                                   {At(Box(Vec3(0.03, 0.02, 0.008)), Vec3(0, 0, 0.0045))}},
                                  kMu, Vec3(0, 0, -kGravity), ContactModel::kRefined);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0.03, 0, 0.0044)});
  RunFrames(world, inputs, 80);
  inputs.hand.body = -1;
  RunFrames(world, inputs, 10);
  const Vec3 from = world.state(0).X_WB.p;
  const double speed = world.state(0).V_WB.v.x();
  ASSERT_GT(speed, 0.1);
  const auto energy = [&] {
    return KineticEnergy(*model, 0, world.state(0)) +
           model->bodies[0].inertia.mass * kGravity * (world.state(0).X_WB.p.z() - from.z());
  };
  const double thrown = energy();
  double least = thrown;
  for (int frame = 0; frame < 1500; ++frame) {
    world.Step(inputs);
    ASSERT_LE(energy(), least + 1e-3 * thrown) << "frame " << frame;
    least = std::min(least, energy());
  }
  const double way = world.state(0).X_WB.p.x() - from.x();
  EXPECT_NEAR(way, speed * speed / (2 * kMu * kGravity), 0.05 * way + 0.02 * kVoxel);
  EXPECT_LT(world.state(0).V_WB.v.norm(), kCreepSpeed);
}

// Boxes dropped at random turns onto a plate tumble to rest. Kinetic energy, potential energy and
// that of contact springs never exceed what there was at the drop.
TEST(Friction, TumblingBoxesNeverGainEnergyAndComeToRest) {
  kHapticThread.Enter();
  std::mt19937_64 random(31);
  const TriangleMesh plate = At(Box(Vec3(0.16, 0.16, 0.008)), Vec3(0, 0, -0.004));
  for (int trial = 0; trial < 6; ++trial) {
    const auto model = WithFriction(
        {{plate, true},
         {At(Box(Vec3(0.02, 0.016, 0.012)), Vec3(0, 0, 0.03), RandomRotation(random))}},
        0.6, Vec3(0, 0, -kGravity), ContactModel::kRefined);
    World world(model);
    const StepInputs inputs = FreeInputs(*model);
    const double weight = model->bodies[0].inertia.mass * kGravity;
    const auto energy = [&] {
      return KineticEnergy(*model, 0, world.state(0)) + weight * world.state(0).X_WB.p.z();
    };
    const double dropped = energy();
    for (int frame = 0; frame < 2500; ++frame) {
      world.Step(inputs);
      ASSERT_LE(energy(), 1.001 * dropped) << "trial " << trial << ", frame " << frame;
    }
    EXPECT_LT(KineticEnergy(*model, 0, world.state(0)), 1e-6 * dropped) << "trial " << trial;
  }
}

// Two free balls that graze each other: friction sets both turning, and neither their momentum nor
// their moment of momentum changes.
TEST(Friction, IsEqualAndOppositeOnTwoBodiesThatMove) {
  kHapticThread.Enter();
  for (const double mass : {0.05, 0.3, 2.0}) {
    const auto model = WithFriction({{Sphere(0.010, 4), false, 0.3},
                                     {At(Sphere(0.012, 4), Vec3(0.028, 0.012, 0)), false, mass}},
                                    0.5, Vec3::Zero(), ContactModel::kRefined);
    World world(model);
    StepInputs inputs = FreeInputs(*model);
    inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0.004, 0, 0)});
    RunFrames(world, inputs, 15);
    inputs.hand.body = -1;
    const auto momentum = [&] {
      Vec3 sum = Vec3::Zero();
      for (std::size_t b = 0; b < 2; ++b)
        sum += model->bodies[b].inertia.mass * world.state(b).V_WB.v;
      return sum;
    };
    const auto energy = [&] {
      return KineticEnergy(*model, 0, world.state(0)) + KineticEnergy(*model, 1, world.state(1));
    };
    const Vec3 thrown = momentum();
    const double energy_thrown = energy();
    ASSERT_GT(thrown.x(), 0.01);
    ASSERT_LT(world.state(1).V_WB.w.norm(), 1e-9);
    int pushed = 0;
    for (int frame = 0; frame < 600; ++frame) {
      const Vec3 before = momentum();
      const StepReport& report = world.Step(inputs);
      pushed += report.pushing_points > 0 ? 1 : 0;
      ASSERT_LE(energy(), 1.001 * energy_thrown) << "mass " << mass << ", frame " << frame;
      if ((report.flags & StepReport::kTravelLimited) != 0) continue;
      ASSERT_LT((momentum() - before).norm(), 1e-12) << "mass " << mass << ", frame " << frame;
    }
    EXPECT_GT(pushed, 0) << "mass " << mass;
    EXPECT_GT(std::abs(world.state(0).V_WB.w.z()), 0.1) << "mass " << mass;
    EXPECT_GT(std::abs(world.state(1).V_WB.w.z()), 0.1) << "mass " << mass;
  }
}

}  // namespace
}  // namespace tandem
