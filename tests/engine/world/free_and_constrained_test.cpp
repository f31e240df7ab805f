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
using testing::RandomDirection;
using testing::RandomRotation;
using testing::RunFrames;
using testing::Sphere;
using testing::TestBody;
using testing::Uniform;

const Vec3 kDown(0, 0, -9.81);

/// Makes a world whose body 0 is held by a constraint, made from its first pose.
template <typename Make>
std::shared_ptr<const WorldModel> Constrained(const std::vector<TestBody>& bodies, const Make& make,
                                              const Vec3& gravity_W = Vec3::Zero()) {
  auto model = std::make_shared<WorldModel>(*MakeWorldModel(bodies, kVoxel));
  model->bodies[0].constraint = make(model->bodies[0].X_WB0);
  model->scene.gravity_W = gravity_W;
  return model;
}

std::shared_ptr<const WorldModel> WithGravity(const std::vector<TestBody>& bodies,
                                              const Vec3& gravity_W = kDown) {
  auto model = std::make_shared<WorldModel>(*MakeWorldModel(bodies, kVoxel));
  model->scene.gravity_W = gravity_W;
  return model;
}

// v = g t and z = g t^2 / 2 exactly, until the free travel bound of 32 m/s, which is where the body
// then stays.
TEST(FreeBody, FallsQuadraticallyUpToTheTravelBound) {
  kHapticThread.Enter();
  const auto model = WithGravity({{Box(Vec3(0.02, 0.02, 0.02))}}, Vec3(0, 0, -20.0));
  World world(model);
  const StepInputs inputs = FreeInputs(*model);
  const double bound = 32.0 * kVoxel / kFrame;
  for (int n = 1; n <= 2000; ++n) {
    world.Step(inputs);
    const RigidState& state = world.state(0);
    if (n * kFrame * 20.0 < bound) {
      ASSERT_NEAR(state.V_WB.v.z(), -20.0 * n * kFrame, 1e-9);
      ASSERT_NEAR(state.X_WB.p.z(), -10.0 * kFrame * kFrame * n * n, 1e-9);
    }
    ASSERT_LE(state.V_WB.v.norm(), bound * (1 + 1e-12));
  }
  EXPECT_NEAR(world.state(0).V_WB.v.norm(), bound, 1e-6);
}

TEST(FreeBody, ParkedAndMirroredBodiesDoNotFall) {
  kHapticThread.Enter();
  const auto model =
      WithGravity({{Box(Vec3(0.02, 0.02, 0.02))}, {At(Sphere(0.01, 2), Vec3(1, 0, 0))}});
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[0].drive = BodyDrive::kParked;
  inputs.instances[1].drive = BodyDrive::kMirrored;
  inputs.instances[1].mirror_WB = model->bodies[1].X_WB0;
  RunFrames(world, inputs, 200);
  EXPECT_EQ(world.state(0).X_WB.p, model->bodies[0].X_WB0.p);
  EXPECT_EQ(world.state(1).X_WB.p, model->bodies[1].X_WB0.p);
}

// A box dropped askew tumbles onto a plate and comes to lie on one of its faces.
TEST(FreeBody, ABoxComesToRestOnAPlate) {
  kHapticThread.Enter();
  std::mt19937_64 random(20);
  const TriangleMesh plate = At(Box(Vec3(0.12, 0.12, 0.008)), Vec3(0, 0, -0.004));
  for (int trial = 0; trial < 6; ++trial) {
    const auto model =
        WithGravity({{plate, true},
                     {At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0, 0, 0.025), RandomRotation(random))}});
    World world(model);
    const StepInputs inputs = FreeInputs(*model);
    RunFrames(world, inputs, 3000);
    const double height = world.state(0).X_WB.p.z();
    EXPECT_NEAR(height, 0.010 + 0.5 * kVoxel, 0.7 * kVoxel) << "trial " << trial;
    double peak = 0;
    for (int frame = 0; frame < 500; ++frame) {
      world.Step(inputs);
      peak = std::max(peak, world.state(0).V_WB.v.norm());
    }
    EXPECT_LT(peak, 2e-3) << "trial " << trial;
    EXPECT_NEAR(world.state(0).X_WB.p.z(), height, 0.05 * kVoxel) << "trial " << trial;
  }
}

/// Two bodies of which the first has been thrown at the second by a hand that let go.
class Collision {
 public:
  Collision(const TriangleMesh& thrown, const TriangleMesh& hit, double mass, ContactModel contact)
      : model_(MakeWorldModel({{thrown}, {hit, false, mass}}, kVoxel, contact)),
        world_(model_),
        inputs_(FreeInputs(*model_)) {
    inputs_.hand = HandTo(*model_, 0, {Quat::Identity(), Vec3(0.002, 0, 0)});
    RunFrames(world_, inputs_, 20);
    inputs_.hand.body = -1;
  }

  const StepReport& Step() {
    kHapticThread.Enter();
    return world_.Step(inputs_);
  }
  Vec3 Momentum() const {
    return model_->bodies[0].inertia.mass * world_.state(0).V_WB.v +
           model_->bodies[1].inertia.mass * world_.state(1).V_WB.v;
  }
  double Energy() const {
    return KineticEnergy(*model_, 0, world_.state(0)) + KineticEnergy(*model_, 1, world_.state(1));
  }

 private:
  std::shared_ptr<const WorldModel> model_;
  World world_;
  StepInputs inputs_;
};

// Each body gets what the other loses, whatever the shapes, the masses and the contact model, in
// every frame in which neither was held back.
TEST(FreeBody, BodiesThatCollideKeepTheirMomentum) {
  kHapticThread.Enter();
  std::mt19937_64 random(23);
  for (const double mass : {0.02, 0.3, 5.0}) {
    for (const ContactModel contact : {ContactModel::kRefined, ContactModel::kPlain}) {
      Collision collision(
          Box(Vec3(0.02, 0.02, 0.02)),
          At(Box(Vec3(0.03, 0.02, 0.01)), Vec3(0.035, 0.004, 0.003), RandomRotation(random)), mass,
          contact);
      ASSERT_GT(collision.Momentum().x(), 0.01);
      int pushed = 0;
      for (int frame = 0; frame < 1000; ++frame) {
        const Vec3 before = collision.Momentum();
        const StepReport report = collision.Step();
        if ((report.flags & StepReport::kTravelLimited) != 0) continue;
        pushed += report.pushing_points > 0 ? 1 : 0;
        ASSERT_LT((collision.Momentum() - before).norm(), 1e-12) << "frame " << frame;
      }
      EXPECT_GT(pushed, 0) << "mass " << mass;
    }
  }
}

// A ball hits a ball, off centre. Solved one by one they would trade velocities, and the lighter
// ball would make ten times the energy that there was. Contact is damped so that nothing springs
// back.
TEST(FreeBody, BallsThatCollideNeverGainEnergy) {
  kHapticThread.Enter();
  std::mt19937_64 random(24);
  for (const double mass : {0.02, 0.3, 5.0}) {
    for (int trial = 0; trial < 4; ++trial) {
      const Vec3 place(0.03, 0.01 * Uniform(random, -1, 1), 0.01 * Uniform(random, -1, 1));
      Collision collision(Sphere(0.012, 4), At(Sphere(0.010, 4), place, RandomRotation(random)),
                          mass, ContactModel::kRefined);
      const double thrown = collision.Energy();
      int pushed = 0;
      for (int frame = 0; frame < 1000; ++frame) {
        pushed += collision.Step().pushing_points > 0 ? 1 : 0;
        ASSERT_LE(collision.Energy(), 1.001 * thrown) << "mass " << mass << ", frame " << frame;
      }
      EXPECT_GT(pushed, 0) << "mass " << mass;
      EXPECT_LT(collision.Energy(), 0.999 * thrown) << "mass " << mass;
    }
  }
}

// In free space kinetic energy and that of the hand's spring together fall from frame to frame,
// and no point goes farther than half a hyperchunk.
TEST(ThrownGoal, DistantGoalAddsNoEnergyAfterTheThrow) {
  kHapticThread.Enter();
  std::mt19937_64 random(21);
  for (const double mass : {0.03, 0.3, 3.0}) {
    const auto model = MakeWorldModel({{Box(Vec3(0.05, 0.01, 0.01)), false, mass}}, kVoxel);
    const Pose goal{RandomRotation(random), 0.5 * RandomDirection(random)};
    World world(model);
    StepInputs inputs = FreeInputs(*model);
    inputs.hand = HandTo(*model, 0, goal);
    const CouplingGains& gains = inputs.hand.gains;
    const auto energy = [&] {
      const RigidState& state = world.state(0);
      const Vec3 turn = RotationVector(goal.q * state.X_WB.q.conjugate());
      return KineticEnergy(*model, 0, state) +
             0.5 * gains.stiffness * (goal.p - state.X_WB.p).squaredNorm() +
             0.5 * turn.dot(gains.rotation_stiffness * turn);
    };
    const double thrown = energy();
    double least = thrown;
    for (int frame = 0; frame < 8000; ++frame) {
      const Vec3 before = world.state(0).X_WB.p;
      world.Step(inputs);
      ASSERT_LE((world.state(0).X_WB.p - before).norm(), 32.0 * kVoxel);
      // turning stiffness is isotropic about no axis, so its energy is not exactly the spring's
      ASSERT_LE(energy(), least + 1e-3 * thrown) << "mass " << mass << ", frame " << frame;
      least = std::min(least, energy());
    }
    EXPECT_LT(energy(), 1e-6 * thrown);
  }
}

// The body is thrown at a plate that stands in the way. No surface point ever goes faster than the
// bound, which is half a voxel a frame as soon as a point may meet something. The peaks of energy
// of the seconds that follow fall.
TEST(ThrownGoal, BodyStopsAtThePlateWithinTheBound) {
  kHapticThread.Enter();
  std::mt19937_64 random(22);
  const TriangleMesh plate = At(Box(Vec3(0.5, 0.5, 0.01)), Vec3(0, 0, -0.005));
  for (int trial = 0; trial < 4; ++trial) {
    const TriangleMesh body =
        At(Box(Vec3(0.016, 0.012, 0.010)), Vec3(0, 0, 0.1), RandomRotation(random));
    const auto model = MakeWorldModel({{plate, true}, {body}}, kVoxel);
    World world(model);
    StepInputs inputs = FreeInputs(*model);
    Vec3 way = RandomDirection(random);
    way.z() = -2.0 - std::abs(way.z());
    inputs.hand =
        HandTo(*model, 0, {RandomRotation(random), Vec3(0, 0, 0.1) + 0.5 * way.normalized()});
    const std::vector<Vec3> corners = testing::CornersOf(*model, 0);
    std::vector<double> peaks;
    for (int window = 0; window < 8; ++window) {
      double peak = 0;
      for (int frame = 0; frame < 500; ++frame) {
        const Pose before = world.state(0).X_WB;
        const bool touched = world.Step(inputs).contact_points > 0;
        const Pose& after = world.state(0).X_WB;
        const double bound = (touched ? 0.5 : 32.0) * kVoxel * (1 + 1e-6);
        for (const Vec3& corner : corners) {
          ASSERT_LE((after * corner - before * corner).norm(), bound);
        }
        peak = std::max(peak, KineticEnergy(*model, 0, world.state(0)));
      }
      peaks.push_back(peak);
    }
    EXPECT_GT(world.state(0).X_WB.p.z(), 0.0) << "trial " << trial;
    EXPECT_LT(peaks.back(), 1e-3 * peaks.front()) << "trial " << trial;
    for (std::size_t k = 3; k < peaks.size(); ++k) {
      EXPECT_LE(peaks[k], 1.01 * peaks[k - 1] + 1e-7) << "trial " << trial << ", window " << k;
    }
  }
}

/// Returns the farthest that a point fixed in a body has come from where it stood.
double Drift(const Pose& X_WB0, const Pose& X_WB, const Vec3& p_W) {
  return (X_WB * (X_WB0.Inverse() * p_W) - p_W).norm();
}

// A hand that pulls every which way pulls a door shut against a block. Two points of the door's
// axis never leave their place, the block stops it, and it opens again.
TEST(ConstrainedBody, ADoorTurnsOnItsHingeAndStopsAtABlock) {
  kHapticThread.Enter();
  const TriangleMesh door = At(Box(Vec3(0.06, 0.004, 0.04)), Vec3(0.03, 0, 0));
  const TriangleMesh block = At(Box(Vec3(0.01, 0.01, 0.03)), Vec3(0.045, 0.02, 0));
  const Vec3 on_axis = Vec3::Zero();
  const auto model = Constrained({{door}, {block, true}}, [&](const Pose& X_WB0) {
    return HingeConstraint(X_WB0, on_axis, Vec3(0, 0, 3));
  });
  const Pose X_WB0 = model->bodies[0].X_WB0;
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  double drift = 0;
  int loaded = 0;
  double most_open = 0;
  for (int frame = 0; frame < 6000; ++frame) {
    // about the hinge by 1.2 rad, and 30 mm away from where the hinge lets it go
    const double angle = frame < 4000 ? 1.2 : -0.5;
    const Pose turned = Pose{RotationBy(Vec3(0, 0, angle)), Vec3::Zero()} * X_WB0;
    const Vec3 aside = 0.03 * Vec3(std::sin(0.01 * frame), 0.3, std::cos(0.013 * frame));
    inputs.hand = HandTo(*model, 0, {RotationBy(Vec3(0.4, 0, 0)) * turned.q, turned.p + aside});
    loaded += world.Step(inputs).pushing_points > 0 ? 1 : 0;
    const Pose& X_WB = world.state(0).X_WB;
    drift = std::max(drift, Drift(X_WB0, X_WB, on_axis));
    drift = std::max(drift, Drift(X_WB0, X_WB, on_axis + Vec3(0, 0, 0.02)));
    most_open = std::max(most_open, RotationVector(X_WB.q * X_WB0.q.conjugate()).z());
  }
  EXPECT_LT(drift, 1e-12);
  EXPECT_GT(loaded, 1000);
  // the door's face, 2 mm from its middle plane, would meet the block's corner at (50, 15) mm at
  // this angle; force begins less than a voxel before
  const double shut = std::atan2(15.0, 50.0) - std::asin(2.0 / std::hypot(15.0, 50.0));
  EXPECT_LT(most_open, shut);
  EXPECT_GT(most_open, shut - kVoxel / 0.052);
  EXPECT_NEAR(RotationVector(world.state(0).X_WB.q * X_WB0.q.conjugate()).z(), -0.5, 0.2);
}

// A part may only slide on a plane, with gravity across it and a hand that lifts. It stays in the
// plane, turns about its normal alone, and stops at a wall.
TEST(ConstrainedBody, PlanarPartStaysInItsPlane) {
  kHapticThread.Enter();
  const TriangleMesh wall = At(Box(Vec3(0.01, 0.2, 0.04)), Vec3(0.045, 0, 0));
  const Vec3 normal = Vec3(1, 0, 4).normalized();
  const auto model = Constrained(
      {{Box(Vec3(0.02, 0.03, 0.01))}, {wall, true}},
      [&](const Pose& X_WB0) {
        return PlaneConstraint(X_WB0, normal, Constraint::Turn::kAboutAxis);
      },
      kDown);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  const Pose X_WB0 = model->bodies[0].X_WB0;
  int loaded = 0;
  for (int frame = 0; frame < 4000; ++frame) {
    inputs.hand =
        HandTo(*model, 0, {RotationBy(Vec3(0.5, -0.3, 0.8)) * X_WB0.q, Vec3(0.1, 0.02, 0.05)});
    loaded += world.Step(inputs).pushing_points > 0 ? 1 : 0;
    const Pose& X_WB = world.state(0).X_WB;
    ASSERT_LT(std::abs(normal.dot(X_WB.p - X_WB0.p)), 1e-12);
    ASSERT_LT(normal.cross(RotationVector(X_WB.q * X_WB0.q.conjugate())).norm(), 1e-12);
  }
  EXPECT_GT(loaded, 1000);
  EXPECT_LT(world.state(0).X_WB.p.x(), 0.035);
  EXPECT_LT(world.state(0).V_WB.v.norm(), 1e-3);
}

TEST(ConstrainedBody, MirrorObeysTheConstraintForAnyReceivedPose) {
  kHapticThread.Enter();
  const auto model = Constrained({{Box(Vec3(0.02, 0.03, 0.01))}}, [](const Pose& X_WB0) {
    return SlideConstraint(X_WB0, Vec3::UnitX());
  });
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.instances[0].drive = BodyDrive::kMirrored;
  inputs.instances[0].mirror_WB = {RotationBy(Vec3(0.3, 0.2, 0.1)), Vec3(0.04, 0.02, -0.03)};
  RunFrames(world, inputs, 200);
  const Pose& X_WB = world.state(0).X_WB;
  EXPECT_NEAR((X_WB.p - Vec3(0.04, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(RotationVector(X_WB.q).norm(), 0.0, 1e-12);
}

TEST(ConstrainedBody, ReportsLimitedTravel) {
  kHapticThread.Enter();
  const auto model =
      Constrained({{At(Box(Vec3(0.06, 0.01, 0.01)), Vec3(0.03, 0, 0))}}, [](const Pose& X_WB0) {
        return HingeConstraint(X_WB0, Vec3::Zero(), Vec3::UnitZ());
      });
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  const Pose X_WB0 = model->bodies[0].X_WB0;
  for (int frame = 0; frame < 100; ++frame) {
    const Pose slow = Pose{RotationBy(Vec3(0, 0, 1e-4 * frame)), Vec3::Zero()} * X_WB0;
    inputs.hand = HandTo(*model, 0, slow);
    ASSERT_EQ(world.Step(inputs).flags & StepReport::kTravelLimited, 0U);
  }
  // 40 kN at a body of 0.3 kg
  inputs.hand = HandTo(*model, 0, {X_WB0.q, X_WB0.p + Vec3(0, 50, 0)});
  EXPECT_NE(world.Step(inputs).flags & StepReport::kTravelLimited, 0U);
}

// The body of fewer points is the pointshell unless the scene says otherwise; either way the two
// push each other apart.
TEST(Pairs, SceneChoosesThePointshell) {
  kHapticThread.Enter();
  const std::vector<testing::TestBody> bodies{{Box(Vec3(0.04, 0.04, 0.01))},
                                              {At(Sphere(0.006, 3), Vec3(0, 0, 0.02))}};
  for (const bool chosen : {false, true}) {
    auto model = std::make_shared<WorldModel>(*MakeWorldModel(bodies, kVoxel));
    model->scene.bodies[0].name = "plate";
    model->scene.bodies[1].name = "ball";
    if (chosen) model->scene.pairs = {{"plate", "ball"}};
    World world(model);
    ASSERT_EQ(world.pair_count(), 1U);
    EXPECT_EQ(world.shell_of(0), chosen ? 0U : 1U);
    EXPECT_EQ(world.voxmap_of(0), chosen ? 1U : 0U);
    StepInputs inputs = FreeInputs(*model);
    inputs.instances[0].drive = BodyDrive::kParked;
    inputs.hand = HandTo(*model, 1, {Quat::Identity(), Vec3(0, 0, 0)});
    int loaded = 0;
    for (int frame = 0; frame < 1000; ++frame) loaded += world.Step(inputs).pushing_points;
    EXPECT_GT(loaded, 100);
    EXPECT_GT(world.state(1).X_WB.p.z(), 0.010);  // the ball's middle, over the plate's face
  }
}

}  // namespace
}  // namespace tandem
