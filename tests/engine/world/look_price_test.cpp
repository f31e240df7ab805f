// Exact looks are part of what a frame may cost (paper §5): by counts, so the same everywhere.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "engine/contact/max_travel.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::MakeWorldModel;
using testing::Sphere;

constexpr double kVoxel = 0.001;
constexpr double kRadius = 0.01;
constexpr int kFrames = 600;
constexpr int kSettled = 300;  // frames until the ball turns as fast as it goes

/// A block with a round hollow inside.
TriangleMesh Hollow(double side, double radius) {
  TriangleMesh mesh = Box(Vec3::Constant(side));
  const TriangleMesh hollow = Sphere(radius, 4);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), hollow.vertices.begin(), hollow.vertices.end());
  for (const auto& triangle : hollow.triangles) {
    mesh.triangles.push_back({first + triangle[0], first + triangle[2], first + triangle[1]});
  }
  return mesh;
}

std::shared_ptr<const WorldModel> BallInHollow() {
  return MakeWorldModel({{Hollow(0.03, kRadius), true}, {Sphere(kRadius - 0.6 * kVoxel, 4)}},
                        kVoxel);
}

struct Ride {
  double looks = 0;   // a frame, in the mean; points sifted by their share of one
  double tests = 0;   // points
  double travel = 0;  // m, of the ball's surface
  double most_cost = 0;
  std::vector<double> travels;  // of each frame
};

/// A hand that turns the ball as fast as it goes.
Ride Turn(const std::shared_ptr<const WorldModel>& model, double capacity, double look_price) {
  kHapticThread.Enter();
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.capacity = capacity;
  inputs.look_price = look_price;
  const Vec3 axis = Vec3(1, 0.3, 0.2).normalized();
  Ride ride;
  for (int frame = 0; frame < kSettled + kFrames; ++frame) {
    const Pose& X_WB = world.state(0).X_WB;
    inputs.hand = HandTo(*model, 0, {RotationBy(1.0 * axis) * X_WB.q, Vec3(0, 0, -0.001)});
    const StepReport& report = world.Step(inputs);
    if (frame < kSettled) continue;
    const double travel = kFrame * world.state(0).V_WB.w.norm() * kRadius;
    const auto tests = static_cast<double>(report.tests.looked_up);
    const double looks = report.looks + kSiftShare * report.sifted_points;
    ride.looks += looks / kFrames;
    ride.tests += tests / kFrames;
    ride.travel += travel / kFrames;
    ride.most_cost = std::max(ride.most_cost, tests + look_price * looks);
    ride.travels.push_back(travel);
  }
  return ride;
}

// A fast turn costs more than the frame has room for: the ball is slowed until it fits; and it
// turns evenly, for the limit does not swing. What the sieve takes does not depend on the travel,
// so it fits where regions hold: not far above the floor.
TEST(LookPrice, SlowsAHeavyContactUntilItsFrameFits) {
  const auto model = BallInHollow();
  constexpr double kPrice = 400;
  const Ride free = Turn(model, 1e9, kPrice);
  const double costs = free.tests + kPrice * free.looks;
  std::printf("  free: %.1f looks, %.0f tests, %.4f voxels a frame\n", free.looks, free.tests,
              free.travel / kVoxel);
  double before = free.travel;
  for (const double share : {0.8, 0.7, 0.6}) {
    const double capacity = share * costs;
    const Ride ride = Turn(model, capacity, kPrice);
    const double cost = (ride.tests + kPrice * ride.looks) / capacity;
    double sway = 0;
    for (std::size_t i = 1; i < ride.travels.size(); ++i) {
      sway += std::abs(ride.travels[i] - ride.travels[i - 1]);
    }
    sway /= static_cast<double>(ride.travels.size() - 1) * ride.travel;
    std::printf(
        "  with room for %.0f %%: %.1f looks, %.0f tests, %.4f voxels a frame; %.2f of it, at most "
        "%.2f; from frame to frame by %.2f %%\n",
        100 * share, ride.looks, ride.tests, ride.travel / kVoxel, cost, ride.most_cost / capacity,
        100 * sway);
    EXPECT_LT(cost, 1.0);
    EXPECT_GT(cost, 0.6);
    EXPECT_LT(ride.travel, before);
    EXPECT_GT(ride.travel, 0.9 * kTravelFloor * kVoxel);
    EXPECT_LT(sway, 0.1);
    before = ride.travel;
  }
  const Ride with_room = Turn(model, 1.6 * costs, kPrice);
  EXPECT_GT(with_room.travel, 0.95 * free.travel);
}

TEST(LookPrice, IsNothingToABlockThatSlidesOnAPlate) {
  const auto model = MakeWorldModel({{At(Box(Vec3(0.2, 0.08, 0.01)), Vec3(0, 0, -0.005)), true},
                                     {At(Box(Vec3(0.03, 0.02, 0.01)), Vec3(-0.05, 0, 0.0055))}},
                                    kVoxel);
  kHapticThread.Enter();
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  int looks = 0;
  int loaded_frames = 0;
  int limited_frames = 0;
  for (int frame = 0; frame < 600; ++frame) {
    inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(-0.05 + 1e-4 * frame, 0, 0.004)});
    const StepReport& report = world.Step(inputs);
    looks += report.looks;
    loaded_frames += report.loaded_points > 0 ? 1 : 0;
    limited_frames += (report.flags & StepReport::kOverCapacity) != 0 ? 1 : 0;
  }
  EXPECT_GT(looks, 0);
  EXPECT_GT(loaded_frames, 500);
  EXPECT_EQ(limited_frames, 0);
}

}  // namespace
}  // namespace tandem
