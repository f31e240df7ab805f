// Exact queries are part of what a frame may cost (paper §5). They are counted, so the cost is the
// same everywhere.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/contact/schedule/max_travel.h"
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
using testing::Sphere;

constexpr double kBallRadius = 0.01;
constexpr int kFrames = 600;
constexpr int kSettled = 300;  // frames until the ball turns as fast as it goes

std::shared_ptr<const WorldModel> BallInHollow() {
  return MakeWorldModel(
      {{HollowBlock(0.03, kBallRadius), true}, {Sphere(kBallRadius - 0.6 * kVoxel, 4)}}, kVoxel);
}

struct Measured {
  double exact_queries = 0;  // mean a frame
  double tests = 0;          // points
  double travel = 0;         // m; travel of the ball's surface
  double most_cost = 0;
  std::vector<double> travels;  // one for each frame
};

/// Lets a hand turn the ball as fast as it goes.
Measured Turn(const std::shared_ptr<const WorldModel>& model, double capacity, double query_price) {
  kHapticThread.Enter();
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.capacity = capacity;
  inputs.query_price = query_price;
  const Vec3 axis = Vec3(1, 0.3, 0.2).normalized();
  Measured turned;
  for (int frame = 0; frame < kSettled + kFrames; ++frame) {
    const Pose& X_WB = world.state(0).X_WB;
    inputs.hand = HandTo(*model, 0, {RotationBy(1.0 * axis) * X_WB.q, Vec3(0, 0, -0.001)});
    const StepReport& report = world.Step(inputs);
    if (frame < kSettled) continue;
    const double travel = kFrame * world.state(0).V_WB.w.norm() * kBallRadius;
    const auto tests = static_cast<double>(report.tests.looked_up);
    const double exact_queries = report.exact_queries;
    turned.exact_queries += exact_queries / kFrames;
    turned.tests += tests / kFrames;
    turned.travel += travel / kFrames;
    turned.most_cost = std::max(turned.most_cost, tests + query_price * exact_queries);
    turned.travels.push_back(travel);
  }
  return turned;
}

// The cost of queries does not depend on the travel: a ball that fills its hollow costs a frame
// nearly as much where it is held to the floor. So queries do not slow it down, however little room
// there is for them.
TEST(QueryPrice, SlowsHeavyContactOnlyIfThatSavesQueries) {
  const auto model = BallInHollow();
  constexpr double kPrice = 400;
  const Measured free = Turn(model, 1e9, kPrice);
  const auto cost = [](const Measured& turned) {
    return turned.tests + kPrice * turned.exact_queries;
  };
  RecordProperty("free_cost", std::to_string(cost(free)));
  RecordProperty("free_travel_voxels", std::to_string(free.travel / kVoxel));
  ASSERT_GT(free.travel, 0.4 * kVoxel);
  // as tests of their own keep it at the floor, capacity is below what is mandatory
  const Measured floor = Turn(model, 100, kPrice);
  RecordProperty("floor_cost", std::to_string(cost(floor)));
  RecordProperty("floor_travel_voxels", std::to_string(floor.travel / kVoxel));
  EXPECT_LT(floor.travel, 1.1 * kTravelFloor * kVoxel);
  EXPECT_GT(cost(floor), 0.8 * cost(free));
  for (const double share : {0.8, 0.6, 0.4}) {
    const Measured turned = Turn(model, share * cost(free), kPrice);
    SCOPED_TRACE(share);
    EXPECT_GT(turned.travel, 0.95 * free.travel);
    EXPECT_LT(cost(turned), 1.02 * cost(free));
  }
}

TEST(QueryPrice, DoesNotSlowABlockSlidingOnAPlate) {
  const auto model = MakeWorldModel({{At(Box(Vec3(0.2, 0.08, 0.01)), Vec3(0, 0, -0.005)), true},
                                     {At(Box(Vec3(0.03, 0.02, 0.01)), Vec3(-0.05, 0, 0.0055))}},
                                    kVoxel);
  kHapticThread.Enter();
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  int exact_queries = 0;
  int loaded_frames = 0;
  int limited_frames = 0;
  for (int frame = 0; frame < 600; ++frame) {
    inputs.hand = HandTo(*model, 0, {Quat::Identity(), Vec3(-0.05 + 1e-4 * frame, 0, 0.004)});
    const StepReport& report = world.Step(inputs);
    exact_queries += report.exact_queries;
    loaded_frames += report.pushing_points > 0 ? 1 : 0;
    limited_frames += (report.flags & StepReport::kOverCapacity) != 0 ? 1 : 0;
  }
  EXPECT_GT(exact_queries, 0);
  EXPECT_GT(loaded_frames, 500);
  EXPECT_EQ(limited_frames, 0);
}

}  // namespace
}  // namespace tandem
