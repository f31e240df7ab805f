// Tests free bodies in a world against closed form: a brick that slides, a pendulum on a hinge and
// a spinning top. Their total energy never rises.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/engine/world/total_energy.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::KineticEnergy;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RunFrames;
using testing::Sphere;
using testing::TestBody;
using testing::TotalEnergy;

constexpr double kStandardGravity = 9.81;
constexpr double kMostRisen = 1e-3;  // share of the energy exchanged
const Vec3 kGravityDown_W(0, 0, -kStandardGravity);

/// Returns a world's model for a brick on a plate, under gravity that leans by `angle`.
std::shared_ptr<const WorldModel> BrickOnASlope(double angle, double friction) {
  auto model = std::make_shared<WorldModel>(
      *MakeWorldModel({{At(Box(Vec3(0.25, 0.05, 0.006)), Vec3(0.08, 0, -0.003)), true},
                       {At(Box(Vec3(0.03, 0.02, 0.008)), Vec3(0, 0, 0.004 + 0.45 * kVoxel))}},
                      kVoxel));
  model->scene.friction = friction;
  model->scene.gravity_W = RotationBy(Vec3(0, -angle, 0)) * kGravityDown_W;
  return model;
}

TEST(ClosedForm, ABrickSlidesUpToTheTravelLimitAndGainsNoEnergy) {
  kHapticThread.Enter();
  constexpr double kMu = 0.3;
  for (const double degrees : {20.0, 30.0, 45.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const auto model = BrickOnASlope(angle, kMu);
    World world(model);
    const StepInputs inputs = FreeInputs(*model);
    TotalEnergy energy(*model, world.state(0));
    const double fastest = 0.8 * 0.5 * kVoxel / kFrame;
    int frames = -1;
    double from = 0;
    double speed = 0;
    for (int frame = 0; frame < 3000 && speed < fastest; ++frame) {
      energy.Step(world, inputs);
      speed = world.state(0).V_WB.v.x();
      if (frames >= 0) ++frames;
      if (frames < 0 && speed > 0.04) {
        frames = 0;
        from = speed;
      }
    }
    const double exact = kStandardGravity * (std::sin(angle) - kMu * std::cos(angle));
    EXPECT_NEAR((speed - from) / (frames * kFrame), exact, 0.03 * exact) << degrees;
    EXPECT_LT(energy.risen(), kMostRisen) << degrees;
  }
}

// Below the angle of friction the brick creeps, slower than kCreepSpeed.
TEST(ClosedForm, ABrickBelowTheAngleOfFrictionSticks) {
  kHapticThread.Enter();
  for (const double degrees : {5.0, 10.0, 20.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const auto model = BrickOnASlope(angle, 0.5);
    World world(model);
    const StepInputs inputs = FreeInputs(*model);
    // a body that stands exchanges so little that its fall into contact would count
    RunFrames(world, inputs, 300);
    TotalEnergy energy(*model, world.state(0));
    const double from = world.state(0).X_WB.p.x();
    for (int frame = 0; frame < 300; ++frame) energy.Step(world, inputs);
    const double creep = 1e-4 * std::tan(angle) / 0.5;  // m/s
    EXPECT_NEAR((world.state(0).X_WB.p.x() - from) / 0.3, creep, 0.1 * creep) << degrees;
    EXPECT_LT(energy.risen(), kMostRisen) << degrees;
  }
}

// A body that falls on a plate never has more energy of motion and height than it had, and comes to
// rest. With the springs it may: a body falls into contact for a part of a frame before contact
// resists.
TEST(ClosedForm, WhatLandsGainsNoEnergyOfMotion) {
  kHapticThread.Enter();
  for (const double mass : {0.01, 0.3, 2.0}) {
    for (const bool ball : {true, false}) {
      for (const double height : {1e-5, 1e-4, 1e-3}) {
        const Vec3 p(0, 0, (ball ? 0.01 : 0.004) + 0.45 * kVoxel + height);
        auto model = std::make_shared<WorldModel>(*MakeWorldModel(
            {{At(Box(Vec3(0.25, 0.05, 0.006)), Vec3(0.08, 0, -0.003)), true},
             {At(ball ? Sphere(0.01, 4) : Box(Vec3(0.03, 0.02, 0.008)), p), false, mass}},
            kVoxel));
        model->scene.gravity_W = kGravityDown_W;
        World world(model);
        const StepInputs inputs = FreeInputs(*model);
        double risen = 0;
        for (int frame = 0; frame < 500; ++frame) {
          world.Step(inputs);
          const RigidState& state = world.state(0);
          const double raised = mass * kStandardGravity * (state.X_WB.p.z() - p.z());
          risen = std::max(risen, KineticEnergy(*model, 0, state) + raised);
        }
        EXPECT_LT(risen, kMostRisen * mass * kStandardGravity * height)
            << mass << " kg from " << height << (ball ? ", ball" : ", brick");
        EXPECT_LT(world.state(0).V_WB.v.norm(), 1e-4);
      }
    }
  }
}

/// Returns a world's model for a box that hangs or stands on a joint, with nothing else about it.
std::shared_ptr<WorldModel> BoxOnAJoint(const Vec3& size, const Pose& X_WB) {
  auto model =
      std::make_shared<WorldModel>(*MakeWorldModel({{At(Box(size), X_WB.p, X_WB.q)}}, kVoxel));
  model->scene.gravity_W = kGravityDown_W;
  return model;
}

TEST(ClosedForm, APendulumSwingsForTheExactPeriod) {
  kHapticThread.Enter();
  constexpr double kLength = 0.1;
  for (const double swing : {0.2, 1.5}) {
    const Quat q = RotationBy(Vec3(0, swing, 0));
    const auto model = BoxOnAJoint(Vec3(0.02, 0.02, 0.06), {q, q * Vec3(0, 0, -kLength)});
    BodyModel& body = model->bodies[0];
    body.constraint = HingeConstraint(body.X_WB0, Vec3::Zero(), Vec3::UnitY());
    World world(model);
    const StepInputs inputs = FreeInputs(*model);
    TotalEnergy energy(*model, world.state(0));
    const double mass = body.inertia.mass;
    double mean = 1;  // arithmetic-geometric mean of 1 and cos(swing / 2)
    double other = std::cos(swing / 2);
    for (int i = 0; i < 20; ++i) {
      const double next = 0.5 * (mean + other);
      other = std::sqrt(mean * other);
      mean = next;
    }
    const double moment = mass * kStandardGravity * kLength;
    const double about = body.inertia.I_B(1, 1) + mass * kLength * kLength;
    const double period = 2 * std::numbers::pi * std::sqrt(about / moment) / mean;
    // from the first passage of the lowest place to the fifth after it: two and a half periods
    double begin = 0;
    double end = 0;
    int passages = 0;
    for (int frame = 0; passages < 6 && frame < 4000; ++frame) {
      const double before = world.state(0).X_WB.p.x();
      energy.Step(world, inputs);
      const double now = world.state(0).X_WB.p.x();
      if ((before < 0) == (now < 0)) continue;
      end = (frame + before / (before - now)) * kFrame;
      if (passages++ == 0) begin = end;
    }
    EXPECT_NEAR((end - begin) / 2.5, period, 0.001 * period) << swing;
    EXPECT_LT(energy.risen(), kMostRisen) << swing;
    EXPECT_LT(std::abs(energy.lost()), kMostRisen) << swing;
  }
}

// Roots of I1 cos(tilt) W^2 - I3 w3 W + m g l = 0, with I1 about the tip.
TEST(ClosedForm, ATopPrecessesSteadily) {
  kHapticThread.Enter();
  constexpr double kHeight = 0.03;
  constexpr double kSpin = 200;  // rad/s
  constexpr double kTilt = 0.4;
  const Quat q = RotationBy(Vec3(kTilt, 0, 0));
  const Vec3 axis = q * Vec3::UnitZ();
  const auto model = BoxOnAJoint(Vec3(0.04, 0.04, 0.01), {q, kHeight * axis});
  BodyModel& body = model->bodies[0];
  body.constraint = BallConstraint(body.X_WB0, Vec3::Zero());
  const Inertia& inertia = body.inertia;
  const Mat3 R = body.X_WB0.q.toRotationMatrix();
  const Mat3 I_W = R * inertia.I_B * R.transpose();
  const double I3 = axis.dot(I_W * axis);
  const double I1 = Vec3::UnitX().dot(I_W * Vec3::UnitX()) + inertia.mass * kHeight * kHeight;
  const double a = I1 * std::cos(kTilt);
  const double moment = inertia.mass * kStandardGravity * kHeight;
  const double round = (I3 * kSpin - std::sqrt(I3 * I3 * kSpin * kSpin - 4 * a * moment)) / (2 * a);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  // a body that another peer has moved so far goes on at its twist
  inputs.instances[0].drive = BodyDrive::kMirrored;
  inputs.instances[0].mirror_WB = body.X_WB0;
  world.Step(inputs);
  inputs.instances[0].drive = BodyDrive::kSimulated;
  const Vec3 w = round * (Vec3::UnitZ() - std::cos(kTilt) * axis) + kSpin * axis;
  inputs.instances[0].begin_V_WB = {w, w.cross(body.X_WB0.p)};
  TotalEnergy energy(*model, {body.X_WB0, inputs.instances[0].begin_V_WB});
  double turned = 0;
  world.Step(inputs);
  double before = std::atan2(world.state(0).X_WB.p.y(), world.state(0).X_WB.p.x());
  for (int frame = 0; frame < 1000; ++frame) {
    energy.Step(world, inputs);
    const Vec3& p = world.state(0).X_WB.p;
    const double now = std::atan2(p.y(), p.x());
    turned += std::remainder(now - before, 2 * std::numbers::pi);
    before = now;
    ASSERT_NEAR(p.z(), kHeight * std::cos(kTilt), 0.02 * kHeight) << frame;
  }
  EXPECT_NEAR(turned, round, 0.03 * round);
  EXPECT_LT(energy.risen(), kMostRisen);
}

// Let go without going round, a top sinks, rises again, and gives back what it took.
TEST(ClosedForm, ATopThatIsLetGoNodsAndGainsNoEnergy) {
  kHapticThread.Enter();
  constexpr double kHeight = 0.03;
  const Quat q = RotationBy(Vec3(0.4, 0, 0));
  const Vec3 axis = q * Vec3::UnitZ();
  const auto model = BoxOnAJoint(Vec3(0.04, 0.04, 0.01), {q, kHeight * axis});
  BodyModel& body = model->bodies[0];
  body.constraint = BallConstraint(body.X_WB0, Vec3::Zero());
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[0].drive = BodyDrive::kMirrored;
  inputs.instances[0].mirror_WB = body.X_WB0;
  world.Step(inputs);
  inputs.instances[0].drive = BodyDrive::kSimulated;
  const Vec3 w = 200 * axis;
  inputs.instances[0].begin_V_WB = {w, w.cross(body.X_WB0.p)};
  world.Step(inputs);
  TotalEnergy energy(*model, world.state(0));
  for (int frame = 0; frame < 2000; ++frame) energy.Step(world, inputs);
  EXPECT_LT(energy.risen(), kMostRisen);
  EXPECT_LT(std::abs(energy.lost()), kMostRisen);
}

}  // namespace
}  // namespace tandem
