// A hand holds a body still in a close fit. Nothing of the fit may set it in motion.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "engine/contact/field/field_pair.h"
#include "engine/contact/field/pressed_depth.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::HollowBlock;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RandomDirection;
using testing::RunFrames;
using testing::Sphere;
using testing::Uniform;

constexpr double kRadius = 0.01;
constexpr double kClearance = 0.45;  // voxels at which force begins (decision 0010)

/// Returns a ball in its hollow with so many voxels to spare before it touches on all sides.
std::shared_ptr<const WorldModel> BallInHollow(double spare) {
  const double radius = kRadius - (kClearance + spare) * kVoxel;
  return MakeWorldModel({{HollowBlock(0.03, kRadius), true}, {Sphere(radius, 4)}}, kVoxel);
}

struct Rest {
  double speed = 0;   // voxels a frame; largest speed of the ball's surface
  double ripple = 0;  // N; ripple of the hand's force about its mean
};

/// Holds a ball at a pose and returns what is left of motion after a second.
Rest Hold(const WorldModel& model, World& world, const Pose& X_WG) {
  constexpr int kSettling = 1000;
  constexpr int kFrames = 500;
  kHapticThread.Enter();
  StepInputs inputs = FreeInputs(model);
  inputs.hand = HandTo(model, 0, X_WG);
  Rest rest;
  Vec3 sum = Vec3::Zero();
  double squares = 0;
  for (int frame = 0; frame < kSettling + kFrames; ++frame) {
    const StepReport& report = world.Step(inputs);
    if (frame < kSettling) continue;
    const Twist& V = world.state(0).V_WB;
    rest.speed = std::max(rest.speed, kFrame / kVoxel * (V.v.norm() + kRadius * V.w.norm()));
    sum += report.hand_B_W.f / kFrames;
    squares += report.hand_B_W.f.squaredNorm() / kFrames;
  }
  rest.ripple = std::sqrt(std::max(0.0, squares - sum.squaredNorm()));
  return rest;
}

/// Balls are turned about this axis.
const Vec3 kAxis = Vec3(1, 0.3, 0.2).normalized();

// Edges of the ball lie along those of the hollow.
TEST(CloseFit, HeldBallComesToRest) {
  for (const double spare : {0.05, 0.1, 0.15, 0.25, 0.35, 0.55, 1.0}) {
    const auto model = BallInHollow(spare);
    for (const double turn : {0.0, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2}) {
      for (const Vec3& pull : {Vec3(0, 0, -1), Vec3(0.3, -0.5, -0.8)}) {
        World world(model);
        const Rest rest = Hold(*model, world, {RotationBy(turn * kAxis), kVoxel * pull});
        EXPECT_LT(rest.speed, 1e-4) << spare << " voxels to spare, turned by " << turn;
        EXPECT_LT(rest.ripple, 1e-3) << spare << " voxels to spare, turned by " << turn;
      }
    }
  }
}

/// Moves a ball in its hollow and counts the jumps of its force above `jump` (N) that are left when
/// ways are cut down to nothing: where it lies still, force is a function of its pose.
int CountJumps(BodyPair& pair, double jump, bool rolls, int ways) {
  std::mt19937_64 random(31);
  const auto force = [&](const Pose& X_WB) {
    return Vec3(pair.Read({X_WB, {}, rolls}, {}).on_shell.force.tail<3>());
  };
  constexpr int kSteps = 64;
  int jumps = 0;
  double most_force = 0;
  for (int way = 0; way < ways; ++way) {
    const Vec3 from = 0.15 * kVoxel * RandomDirection(random);
    const Vec3 go = 0.25 * kVoxel * RandomDirection(random);
    const Quat q = RotationBy(Uniform(random, 0.0, 0.05) * RandomDirection(random));
    const auto at = [&](double share) {
      return force({q, from + share * go});
    };
    for (int step = 0; step < kSteps; ++step) {
      double low = step / static_cast<double>(kSteps);
      double high = low + 1.0 / kSteps;
      Vec3 below = at(low);
      Vec3 above = at(high);
      most_force = std::max(most_force, below.norm());
      for (int cut = 0; cut < 20 && (above - below).norm() > jump; ++cut) {
        const double middle = 0.5 * (low + high);
        const Vec3 between = at(middle);
        const bool lower = (between - below).norm() > (above - between).norm();
        (lower ? high : low) = middle;
        (lower ? above : below) = between;
      }
      jumps += (above - below).norm() > jump ? 1 : 0;
    }
  }
  EXPECT_GT(most_force, 10.0);
  return jumps;
}

// A voxel of depth on one point is 75 N.
TEST(CloseFit, ForceDoesNotJumpAsABallMovesInItsHollow) {
  const auto model = BallInHollow(0.15);
  const BodyModel& ball = model->bodies[0];
  FieldPair pair(ball.surface, model->fixture_surface, {},
                 DefaultContactGains(kVoxel, ball.inertia.mass, kFrame));
  EXPECT_EQ(CountJumps(pair, 0.2, false, 20), 0);
  EXPECT_EQ(CountJumps(pair, 0.2, true, 4), 0);
}

// A light plug with play of 0.07 mm in a passage, voxels of 0.5 mm, tilted by a hand that turns it:
// both ends press, so force begins at the surface, as in a narrow fit. It lies no deeper than told.
TEST(ContactYield, AHandPressesAPlugNoDeeper) {
  constexpr double kSize = 0.0005;
  constexpr double kPlay = 0.00007;
  kHapticThread.Enter();
  const double half = 0.004;
  const double wall = half + kPlay;
  const auto side = [&](double z) {
    return At(Box(Vec3(0.03, 0.02, 0.004)), Vec3(0, 0, z));
  };
  const auto model = MakeWorldModel({{side(wall + 0.002), true},
                                     {side(-wall - 0.002), true},
                                     {Box(Vec3(0.02, 0.01, 2 * half)), false, 0.02}},
                                    kSize);
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  // a spring of 800 N/m that is drawn by F pulls with F
  const double force = 6.7;
  inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(0, 0, force / 800)});
  RunFrames(world, inputs, 500);
  double deepest = 0;
  for (const Vec3& corner : testing::CornersOf(*model, 0)) {
    deepest = std::max(deepest, (world.state(0).X_WB * corner).z() - wall);
  }
  const ContactYield yield{.voxel_size = kSize, .force = force};
  EXPECT_LE(deepest, yield.PressedDepth());
}

}  // namespace
}  // namespace tandem
