#include "app/view/model/hand/part_picking.h"

#include <gtest/gtest.h>

#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

constexpr std::size_t kBlockBody = 0;
constexpr std::size_t kBallBody = 1;

class Picking : public ::testing::Test {
 protected:
  Picking() {
    camera_.SetViewport(800, 600);
    camera_.LookFrom(StandardView::kFront);
    camera_.Fit(scene_.BoundsOfAll());
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) list_.solids.push_back({i, {}, {}, 1});
  }
  std::optional<PartHit> PickAt(const Vec3& p_W) {
    return PickPart(camera_.RayThrough(*camera_.Project(p_W)), scene_, list_);
  }

  DrawnScene scene_ = BlockAndBall();
  DrawList list_;
  CameraModel camera_;
  const Vec3 middle_W_{0, -0.1, 0};  // middle of the ball, 3 cm in radius
};

TEST_F(Picking, FindsTheSurfaceFacingTheEye) {
  const auto hit = PickAt(middle_W_);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->body, kBallBody);
  EXPECT_NEAR((hit->p_W - middle_W_).norm(), 0.03, 0.0006);  // the ball has flat facets
  EXPECT_LT(hit->p_W.y(), -0.129);
}

TEST_F(Picking, FindsAMovedBody) {
  list_.solids[kBallBody].X_W = {RotationBy(Vec3(0, 0, 0.3)), Vec3(0.05, 0.02, 0.04)};
  const Vec3 moved_W = list_.solids[kBallBody].X_W * middle_W_;
  const auto hit = PickAt(moved_W);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->body, kBallBody);
  EXPECT_NEAR((hit->p_W - moved_W).norm(), 0.03, 0.0006);
  EXPECT_EQ(PickAt(middle_W_)->body, kBlockBody);
}

TEST_F(Picking, NearerBodyIsPicked) {
  list_.solids[kBallBody].X_W.p = Vec3(0, 0.2, 0);  // behind the block
  EXPECT_EQ(PickAt(Vec3(0, -0.02, 0))->body, kBlockBody);
  EXPECT_FALSE(PickAt(Vec3(0, 0, 0.14)).has_value());
}

}  // namespace
}  // namespace tandem
