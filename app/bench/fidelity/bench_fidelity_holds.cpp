#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include "app/bench/fidelity/factory_scene.h"
#include "app/bench/fidelity/fidelity.h"
#include "app/bench/fidelity/force_steps.h"
#include "engine/base/check.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/world/world_of_meshes.h"
#include "scenes/generators/shapes.h"

namespace tandem {

namespace {

constexpr double kHoldVoxel = 0.001;    // m
constexpr double kHollowRadius = 0.01;  // m
constexpr int kFineness = 4;            // fineness of the spheres
constexpr std::array<double, 7> kSpares{0.05, 0.1, 0.15, 0.25, 0.35, 0.55, 1.0};        // voxels
constexpr std::array<double, 9> kTurns{0.0, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2};  // rad
constexpr std::size_t kPulls = 2;
static_assert(kSpares.size() * kTurns.size() * kPulls == kMostHolds);

/// Returns a ball in a block with a round hollow. The ball has `spare` voxels all round before
/// force begins. Its edges lie along those of the hollow.
std::shared_ptr<const WorldModel> BallInBlock(double spare) {
  TriangleMesh block = Box(Vec3::Constant(-0.015), Vec3::Constant(0.015));
  TriangleMesh hollow = OctahedralSphere(kHollowRadius, kFineness, false);
  for (TriangleMesh::Triangle& t : hollow.triangles) std::swap(t[1], t[2]);
  Append(block, hollow);
  const double radius = kHollowRadius - (kRefinedClearance + spare) * kHoldVoxel;
  const auto made = WorldOfMeshes({{.mesh_W = std::move(block), .fixed = true},
                                   {.mesh_W = OctahedralSphere(radius, kFineness, false)}},
                                  kHoldVoxel, ContactModel::kRefined);
  TANDEM_CHECK(made.has_value());
  return *made;
}

/// Returns the largest speed of the ball's surface, voxels a frame, after a hand has held it at a
/// pose for two seconds.
double SpeedAfterHold(const std::shared_ptr<const WorldModel>& model, const Pose& X_WG,
                      TimesOfFrames& times) {
  constexpr int kSettling = 2000;
  constexpr int kWatched = 100;
  World world(model);
  StepInputs inputs = HandInputs(*model);
  inputs.hand.goal.X_WA = X_WG;
  double speed = 0;
  for (int frame = 0; frame < kSettling + kWatched; ++frame) {
    TimedStep(world, inputs, times);
    if (frame < kSettling) continue;
    const Twist& V = world.state(0).V_WB;
    speed = std::max(speed, kFrame / kHoldVoxel * (V.v.norm() + kHollowRadius * V.w.norm()));
  }
  return speed;
}

Vec3 DrawnDirection(std::mt19937_64& random) {
  const double z = Uniform(random, -1, 1);
  const double angle = Uniform(random, 0, 2 * std::numbers::pi);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Returns the largest jump of force as the ball goes straight ways in its hollow, N.
double LargestStepInHollow() {
  constexpr int kWays = 20;
  constexpr int kParts = 64;
  const auto model = BallInBlock(0.15);
  const std::unique_ptr<BodyPair> pair = FixturePair(*model);
  std::mt19937_64 random(31);
  double largest = 0;
  for (int way = 0; way < kWays; ++way) {
    const Vec3 from = 0.15 * kHoldVoxel * DrawnDirection(random);
    const Vec3 go = 0.25 * kHoldVoxel * DrawnDirection(random);
    const double angle = Uniform(random, 0.0, 0.05);
    const Quat q = RotationBy(angle * DrawnDirection(random));
    const auto force_at = [&](double share) {
      return ForceAtRest(*pair, {q, from + share * go});
    };
    largest = LargestForceStep(force_at, kParts, largest);
  }
  return largest;
}

}  // namespace

HoldFigures MeasureHolds(int count) {
  constexpr double kStill = 1e-4;  // voxels a frame
  const Vec3 axis = Vec3(1, 0.3, 0.2).normalized();
  const std::array<Vec3, kPulls> pulls{Vec3(0, 0, -1), Vec3(0.3, -0.5, -0.8)};
  HoldFigures figures;
  TimesOfFrames times;
  std::shared_ptr<const WorldModel> model;
  double spare_of_model = 0;
  for (int i = 0; i < count; ++i) {
    // these are as far from one another as `count` allows
    const auto hold = static_cast<std::size_t>(i) * kMostHolds / static_cast<std::size_t>(count);
    const double spare = kSpares[hold / (kTurns.size() * kPulls)];
    const double turn = kTurns[hold / kPulls % kTurns.size()];
    if (spare != spare_of_model) model = BallInBlock(spare);
    spare_of_model = spare;
    const Pose X_WG{RotationBy(turn * axis), kHoldVoxel * pulls[hold % kPulls]};
    const double speed = SpeedAfterHold(model, X_WG, times);
    figures.moving += speed > kStill ? 1 : 0;
    ++figures.count;
  }
  figures.largest_force_step = LargestStepInHollow();
  figures.frames = LengthsOf(times);
  return figures;
}

}  // namespace tandem
