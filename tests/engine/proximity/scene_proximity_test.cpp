#include "engine/proximity/scene_proximity.h"

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::AllocationCounter;
using testing::At;
using testing::Box;
using testing::Sphere;

constexpr double kSceneVoxel = 0.001;
constexpr double kFacets = 1e-5;  // m; by so much the triangles of a sphere of 1 cm miss it

bool GoOn(std::size_t /*done*/, std::size_t /*total*/, const std::string& /*part*/) {
  return true;
}

/// A fixed plate (top at z = 0) with a fixed post, a ball (1) and a large block (3) that move. The
/// ball stands 2 cm above the plate, the block 6 cm beside the ball along x.
class TwoMovingParts : public ::testing::Test {
 protected:
  TwoMovingParts() {
    const std::vector<ProximityBody> bodies{
        {"plate", true, At(Box(Vec3(0.4, 0.2, 0.01)), Vec3(0, 0, -0.005))},
        {"ball", false, At(Sphere(0.01, 4), Vec3(0, 0, 0.03))},
        {"post", true, At(Box(Vec3(0.01, 0.01, 0.05)), Vec3(-0.15, 0, 0.025))},
        {"block", false, At(Box(Vec3(0.04, 0.04, 0.04)), Vec3(0.09, 0, 0.1))}};
    Result<std::vector<ProximityPart>> parts =
        MakeProximityParts(bodies, kSceneVoxel, kDefaultRange, GoOn);
    EXPECT_TRUE(parts.has_value());
    parts_ = std::make_shared<const std::vector<ProximityPart>>(std::move(*parts));
  }
  static constexpr std::size_t kFixture = 0;
  static constexpr std::size_t kBall = 1;
  static constexpr std::size_t kBlock = 2;
  std::shared_ptr<const std::vector<ProximityPart>> parts_;
  std::vector<Pose> X_W_ = std::vector<Pose>(4);  // one for each body
};

TEST_F(TwoMovingParts, FormOneFixtureAndOnePartPerMovingBody) {
  ASSERT_EQ(parts_->size(), 3U);
  EXPECT_EQ((*parts_)[kFixture].name, "fixture");
  EXPECT_TRUE((*parts_)[kFixture].fixed);
  EXPECT_EQ((*parts_)[kBall].name, "ball");
  EXPECT_EQ((*parts_)[kBall].bodies, std::vector<std::size_t>{1});
  EXPECT_EQ((*parts_)[kBlock].bodies, std::vector<std::size_t>{3});
  EXPECT_EQ((*parts_)[kFixture].bodies, (std::vector<std::size_t>{0, 2}));
  EXPECT_DOUBLE_EQ(SceneProximity(parts_).range(), 8 * kSceneVoxel);
}

// The lowest point of a ball 20 voxels off is in sight of a range of 30 voxels and not of 8.
TEST_F(TwoMovingParts, ColoursEndAtTheRange) {
  const std::vector<ProximityBody> bodies{
      {"plate", true, Box(Vec3(0.2, 0.2, 0.01))},
      {"ball", false, At(Sphere(0.01, 4), Vec3(0, 0, 0.005 + 20 * kSceneVoxel + 0.01))}};
  const std::array<std::array<float, 3>, 1> lowest{
      std::array<float, 3>{0, 0, static_cast<float>(0.005 + 20 * kSceneVoxel)}};
  for (const int range : {8, 30}) {
    Result<std::vector<ProximityPart>> parts = MakeProximityParts(bodies, kSceneVoxel, range, GoOn);
    ASSERT_TRUE(parts);
    const SceneProximity scene(
        std::make_shared<const std::vector<ProximityPart>>(std::move(*parts)));
    EXPECT_DOUBLE_EQ(scene.range(), range * kSceneVoxel);
    std::array<float, 1> distance{};
    scene.Distances(kBall, lowest, std::vector<Pose>(2), distance);
    if (range == 8) {
      EXPECT_GT(distance[0], 8 * kSceneVoxel);
    } else {
      EXPECT_NEAR(distance[0], 20 * kSceneVoxel, 2 * kSceneVoxel);
    }
  }
}

TEST_F(TwoMovingParts, NearestPairIsReportedWithPointsInTheWorldFrame) {
  SceneProximity scene(parts_);
  const SceneNearness first = scene.Nearest(X_W_);
  EXPECT_EQ(first.part, kBall);
  EXPECT_EQ(first.other, kFixture);
  EXPECT_NEAR(first.distance, 0.02, kFacets);
  EXPECT_LT((first.p_WPart - Vec3(0, 0, 0.02)).norm(), 1e-3);
  EXPECT_NEAR(first.p_WOther.z(), 0, 1e-9);
  EXPECT_LT((first.gradient_W - Vec3::UnitZ()).norm(), 1e-6);

  // both moved: the block stands beside the ball now, 5 mm from it, and high above the plate
  X_W_[1].p = Vec3(0, 0, 0.07);
  X_W_[3].p = Vec3(-0.055, 0, 0);
  const SceneNearness then = scene.Nearest(X_W_);
  EXPECT_NEAR(then.distance, 0.005, kFacets);
  EXPECT_LE(then.least, 0.005 + kFacets);
  EXPECT_GE(then.most, 0.005 - kFacets);
  EXPECT_LT((then.p_WOther - Vec3(0.015, 0, 0.1)).norm(), 1e-3);
}

TEST_F(TwoMovingParts, PairIsReportedFromBothSides) {
  SceneProximity scene(parts_);
  X_W_[1].p = Vec3(0, 0, 0.07);
  X_W_[3].p = Vec3(-0.055, 0, 0);
  const SceneNearness ball = scene.NearestTo(kBall, X_W_);
  const SceneNearness block = scene.NearestTo(kBlock, X_W_);
  EXPECT_EQ(ball.part, kBall);
  EXPECT_EQ(ball.other, kBlock);
  EXPECT_EQ(block.part, kBlock);
  EXPECT_EQ(block.other, kBall);
  EXPECT_EQ(ball.distance, block.distance);
  EXPECT_EQ(ball.p_WPart, block.p_WOther);
  EXPECT_LT((ball.gradient_W + Vec3::UnitX()).norm(), 1e-6);
  EXPECT_LT((block.gradient_W - Vec3::UnitX()).norm(), 1e-6);
}

// The search looks for the smaller body inside the larger, whichever comes first.
TEST_F(TwoMovingParts, ContainedBallOverlaps) {
  SceneProximity scene(parts_);
  X_W_[1].p = Vec3(0.09, 0, 0.07);
  EXPECT_TRUE(scene.NearestTo(kBall, X_W_).overlap);
  EXPECT_TRUE(scene.NearestTo(kBlock, X_W_).overlap);
  EXPECT_EQ(scene.Nearest(X_W_).distance, 0);
}

TEST_F(TwoMovingParts, DistanceIsToTheNearestBody) {
  const SceneProximity scene(parts_);
  const std::vector<std::array<float, 3>> points{
      {0.0F, 0.0F, 0.02F}, {0.01F, 0.0F, 0.03F}, {0.0F, 0.0F, 0.04F}};
  std::vector<float> distances(points.size());
  scene.Distances(kBall, points, X_W_, distances);
  for (const float d : distances) EXPECT_EQ(d, std::numeric_limits<float>::infinity());
  // 3 mm above the plate and 4 mm beside the block; the ball's top is far from both
  X_W_[1].p = Vec3(0, 0, -0.017);
  X_W_[3].p = Vec3(-0.056, 0, -0.079);
  scene.Distances(kBall, points, X_W_, distances);
  EXPECT_NEAR(distances[0], 0.003, 1.1 * kSceneVoxel);
  EXPECT_NEAR(distances[1], 0.004, 1.1 * kSceneVoxel);
  EXPECT_EQ(distances[2], std::numeric_limits<float>::infinity());
}

TEST_F(TwoMovingParts, ShadowLiesOnTheFixtureUnderEachPart) {
  SceneProximity scene(parts_);
  X_W_[1].p = Vec3(0.01, 0, -0.017);    // 3 mm above the plate, at x = 0.01
  X_W_[3].p = Vec3(-0.15, 0, -0.0765);  // 3.5 mm above it, at x = -0.06
  std::vector<Vec3> centres(20000);
  const ShadowCount count = scene.Shadow(X_W_, 0.0055, centres);
  ASSERT_FALSE(count.capped());
  std::size_t of_ball = 0;
  for (std::size_t i = 0; i < count.written; ++i) {
    const Vec3& p = centres[i];
    EXPECT_LE(p.z(), kSceneVoxel);
    const bool under_ball = (p - Vec3(0.01, 0, 0)).norm() < 0.012;
    const bool under_block = std::abs(p.x() + 0.06) < 0.027 && std::abs(p.y()) < 0.027;
    EXPECT_NE(under_ball, under_block) << p.transpose();
    of_ball += under_ball ? 1 : 0;
  }
  EXPECT_GT(of_ball, 30U);
  EXPECT_GT(count.written - of_ball, 1600U);  // 40 by 40 voxels
  const ShadowCount capped = scene.Shadow(X_W_, 0.0055, std::span(centres).first(100));
  EXPECT_EQ(capped.found, count.found);
  EXPECT_EQ(capped.written, 100U);
}

TEST_F(TwoMovingParts, QueriesAllocateNothing) {
  SceneProximity scene(parts_);
  std::vector<Vec3> centres(100);
  const std::vector<std::array<float, 3>> points(10, {0.0F, 0.0F, 0.02F});
  std::vector<float> distances(10);
  const AllocationCounter allocations;
  const SceneNearness near = scene.Nearest(X_W_);
  const ShadowCount count = scene.Shadow(X_W_, 0.03, centres);
  scene.Distances(kBall, points, X_W_, distances);
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_TRUE(near.refined);
  EXPECT_GT(count.found, 0U);
}

TEST(SceneProximity, MergedBodyMovesWithItsWhole) {
  // a knob that stands 2 cm out of a block towards the plate; it is listed before the block
  Result<std::vector<ProximityPart>> parts =
      MakeProximityParts({{"knob", false, At(Box(Vec3(0.01, 0.01, 0.03)), Vec3(0, 0, 0.065)), 1},
                          {"block", false, At(Box(Vec3(0.04, 0.04, 0.04)), Vec3(0, 0, 0.1))},
                          {"plate", true, At(Box(Vec3(0.2, 0.2, 0.01)), Vec3(0, 0, -0.005))}},
                         kSceneVoxel, kDefaultRange, GoOn);
  ASSERT_TRUE(parts.has_value());
  ASSERT_EQ(parts->size(), 2U);
  EXPECT_EQ((*parts)[1].name, "block");
  EXPECT_EQ((*parts)[1].bodies, (std::vector<std::size_t>{1, 0}));
  SceneProximity scene(std::make_shared<const std::vector<ProximityPart>>(std::move(*parts)));
  std::vector<Pose> X_W(3);
  EXPECT_NEAR(scene.Nearest(X_W).distance, 0.05, 1e-9);
  X_W[1].p = Vec3(0, 0, -0.02);
  EXPECT_NEAR(scene.Nearest(X_W).distance, 0.03, 1e-9);
}

TEST(SceneProximity, SingleBodyHasNoDistance) {
  Result<std::vector<ProximityPart>> parts =
      MakeProximityParts({{"ball", false, Sphere(0.01, 2)}}, kSceneVoxel, kDefaultRange, GoOn);
  ASSERT_TRUE(parts.has_value());
  SceneProximity scene(std::make_shared<const std::vector<ProximityPart>>(std::move(*parts)));
  const std::vector<Pose> X_W(1);
  EXPECT_EQ(scene.Nearest(X_W).other, SceneNearness::kNone);
  EXPECT_EQ(scene.NearestTo(0, X_W).distance, std::numeric_limits<double>::infinity());
  EXPECT_EQ(scene.Shadow(X_W, 1, {}).found, 0U);
}

TEST(SceneProximity, ReportsUnvoxelizablePartsAndCanBeCancelled) {
  const std::vector<ProximityBody> bodies{{"plate", true, Box(Vec3(0.1, 0.1, 0.1))},
                                          {"nothing", false, {}}};
  const auto bad = MakeProximityParts(bodies, kSceneVoxel, kDefaultRange, GoOn);
  ASSERT_FALSE(bad.has_value());
  EXPECT_NE(bad.error().what.find("'nothing'"), std::string::npos) << bad.error().what;
  std::vector<std::string> reported;
  const auto given_up =
      MakeProximityParts(bodies, kSceneVoxel, kDefaultRange,
                         [&](std::size_t done, std::size_t total, const std::string& part) {
                           reported.push_back(part);
                           EXPECT_EQ(total, 2U);
                           return done < 1;
                         });
  EXPECT_FALSE(given_up.has_value());
  EXPECT_EQ(reported, (std::vector<std::string>{"plate", "nothing"}));
}

// The ball goes 0.4 mm into the plate, then the block 2.5 mm.
TEST_F(TwoMovingParts, TellTheDepthOfAnOverlap) {
  SceneProximity scene(parts_);
  X_W_[1].p.z() = -0.0204;
  SceneNearness near = scene.NearestTo(kBall, X_W_, {.depth = true});
  EXPECT_TRUE(near.overlap);
  EXPECT_NEAR(near.depth, 0.0004, 1e-5 + kFacets);
  EXPECT_EQ(scene.NearestTo(kBall, X_W_).depth, 0) << "not asked for";
  // the deepest of all overlaps
  X_W_[3].p.z() = -0.0825;
  near = scene.Nearest(X_W_, {.depth = true});
  EXPECT_EQ(near.part, kBlock);
  EXPECT_NEAR(near.depth, 0.0025, 1e-6);
  X_W_[1].p.z() = 0;
  X_W_[3].p.z() = 0;
  EXPECT_EQ(scene.Nearest(X_W_, {.depth = true}).depth, 0);
}

}  // namespace
}  // namespace tandem
