#include "app/view/model/proximity/proximity_picture.h"

#include <gtest/gtest.h>

#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

constexpr double kGap = 0.05;  // m, between ball and block at first

ProximityComposer ComposerOf(const std::shared_ptr<const DrawnScene>& scene) {
  auto parts = MakeProximityParts(
      ProximityBodiesOf(*scene), scene->voxel_size, scene->range_voxels,
      [](std::size_t /*done*/, std::size_t /*total*/, const std::string& /*part*/) {
        return true;
      });
  EXPECT_TRUE(parts.has_value());
  return {scene, std::move(*parts)};
}

std::vector<Pose> BallMovedBy(const Vec3& p) {
  std::vector<Pose> X_W(2);
  X_W[1].p = p;
  return X_W;
}

class BlockAndBallNear : public ::testing::Test {
 protected:
  std::shared_ptr<const DrawnScene> scene_ = std::make_shared<const DrawnScene>(BlockAndBall());
  ProximityComposer composer_ = ComposerOf(scene_);
};

TEST_F(BlockAndBallNear, VerticesAreWarmWhereTheyAreNearAndColdBeyondTheRange) {
  const ProximityPicture picture = composer_.Compose(BallMovedBy(Vec3(0, kGap - 0.002, 0)));
  ASSERT_EQ(picture.bodies.size(), 1U);  // the block is fixed
  EXPECT_EQ(picture.bodies[0].body, 1U);
  const std::vector<ShadedMesh::Vertex>& vertices = scene_->bodies[1].mesh.vertices;
  ASSERT_EQ(picture.bodies[0].rgba.size(), vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double y =
        static_cast<double>(vertices[i].p[1]) + kGap - 0.002;  // the block's begins at -0.02
    const int warmth = picture.bodies[0].rgba[i][0] - picture.bodies[0].rgba[i][2];
    if (y > -0.0235) {
      EXPECT_GT(warmth, 60);
    }
    if (y < -0.030) {
      EXPECT_LT(warmth, -60);
    }
  }
}

TEST_F(BlockAndBallNear, ReportsTheLeastDistanceAndItsBodies) {
  const ProximityPicture far = composer_.Compose(BallMovedBy(Vec3::Zero()));
  EXPECT_EQ(far.part, "ball");
  EXPECT_EQ(far.other, "block");
  EXPECT_NEAR(far.nearest.distance, kGap, 1e-7);
  EXPECT_TRUE(far.shadow_W.empty());
  EXPECT_EQ(DistanceText(far.nearest, far.yield), "50.000 mm \u00b1 0.001 mm");
  const ProximityPicture within = composer_.Compose(BallMovedBy(Vec3(0, kGap + 0.02, 0)));
  EXPECT_NEAR(within.nearest.depth, 0.02, 1e-4);
  EXPECT_EQ(DistanceText(within.nearest, within.yield).substr(0, 34), "overlap, at least 20.000 mm deep; ");
}

TEST_F(BlockAndBallNear, ShowsTheBlocksVoxelsUnderTheBall) {
  const ProximityPicture picture = composer_.Compose(BallMovedBy(Vec3(0, kGap - 0.002, 0)));
  EXPECT_GT(picture.shadow_W.size(), 20U);
  EXPECT_EQ(picture.shadow_found, picture.shadow_W.size());
  for (const std::array<float, 3>& p : picture.shadow_W) {
    EXPECT_NEAR(p[1], -0.02, 0.001);
    EXPECT_LT(std::hypot(p[0], p[2]), 0.02);
  }
}

TEST(DistanceText, RoundsTheErrorUp) {
  SceneNearness near;
  near.distance = 0.0032;
  near.least = 0.0032 - 1.7321e-3;
  near.most = 0.0032 + 1.7321e-3;
  EXPECT_EQ(DistanceText(near, {}), "3.200 mm \u00b1 1.733 mm");
}

TEST(DistanceText, TellsTheDepthAndTheVoxelThatDecides) {
  SceneNearness pressed;
  pressed.overlap = true;
  pressed.depth = 0.061e-3;
  EXPECT_EQ(DistanceText(pressed, {.voxel_size = 0.0005}),
            "overlap, at least 0.061 mm deep; contact gives 0.1 mm at 10 N; voxel_m 0.00014 decides");
  EXPECT_EQ(DistanceText(pressed, {.voxel_size = 0.0001}),
            "overlap, at least 0.061 mm deep; contact gives 0.021 mm at 10 N: they cross");
  pressed.depth = 0;
  EXPECT_EQ(DistanceText(pressed, {.voxel_size = 0.0005}), "overlap");
}

/// Returns a scene with a second ball beside the block and the ball, 0.1 m to the left.
std::shared_ptr<const DrawnScene> WithASecondBall() {
  DrawnScene scene = BlockAndBall();
  TriangleMesh ball = SphereMesh(0.03, 16, 32);
  for (Vec3& p : ball.vertices) p += Vec3(-0.1, -0.1, 0);
  scene.bodies.push_back(MakeDrawnBody("second", {false, {0.1F, 0.1F, 0.8F}}, ball));
  return std::make_shared<const DrawnScene>(std::move(scene));
}

TEST(SeveralMovingBodiesNear, ReportsTheHeldPart) {
  const std::shared_ptr<const DrawnScene> scene = WithASecondBall();
  ProximityComposer composer = ComposerOf(scene);
  std::vector<Pose> X_W(3);
  X_W[2].p.y() = kGap - 0.002;  // the second is 2 mm before the block, the first 50 mm
  ProximityPicture picture = composer.Compose(X_W, std::vector<std::size_t>{1});
  EXPECT_EQ(picture.part, "second");
  EXPECT_NEAR(picture.nearest.distance, 0.002, 1e-6);
  EXPECT_EQ(picture.held_part, "ball");
  EXPECT_EQ(picture.held_other, "block");
  EXPECT_NEAR(picture.of_held.distance, kGap, 1e-6);
  // there is nothing to add if that is the nearest of all, or nothing is in hand
  EXPECT_EQ(composer.Compose(X_W, std::vector<std::size_t>{2}).of_held.other, SceneNearness::kNone);
  EXPECT_EQ(composer.Compose(X_W, {}).of_held.other, SceneNearness::kNone);
  // the nearer of several in hand counts
  X_W[1].p.y() = kGap - 0.010;
  X_W[2].p.y() = kGap - 0.020;
  picture = composer.Compose(X_W, std::vector<std::size_t>{1, 2});
  EXPECT_EQ(picture.of_held.other, SceneNearness::kNone);
  EXPECT_NEAR(picture.nearest.distance, 0.010, 1e-6);
}

}  // namespace
}  // namespace tandem
