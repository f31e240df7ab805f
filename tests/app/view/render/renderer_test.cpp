#include "app/view/render/renderer.h"

#include <gtest/gtest.h>

#include "app/view/model/scene/refined_mesh.h"
#include "tests/app/view/render/offscreen_gl.h"
#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

constexpr std::size_t kBlock = 0;
constexpr std::size_t kBallBody = 1;
constexpr QSize kSize(320, 240);

/// The block and the ball before it, seen from the front.
class Drawn : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(gl_.ready()) << "no OpenGL: run under xvfb-run";
    ASSERT_FALSE(renderer_.Initialize().has_value());
    scene_ = BlockAndBall();
    renderer_.Upload(scene_.bodies);
    camera_.SetViewport(kSize.width(), kSize.height());
    camera_.LookFrom(StandardView::kFront);
    camera_.Fit(scene_.BoundsOfAll());
    list_.solids = {{kBlock, {}, scene_.bodies[kBlock].look.colour, 1},
                    {kBallBody, {}, scene_.bodies[kBallBody].look.colour, 1}};
  }
  QImage Image() { return gl_.Draw(renderer_, camera_, list_); }
  QColor At(const QImage& image, const Vec3& p_W) const {
    const auto px = camera_.Project(p_W);
    return image.pixelColor(static_cast<int>(px->x()), static_cast<int>(px->y()));
  }
  static bool IsGreen(const QColor& c) {
    return c.green() > c.red() + 60 && c.green() > c.blue() + 60;
  }
  static bool IsGrey(const QColor& c) {
    return std::abs(c.green() - c.red()) < 12 && std::abs(c.green() - c.blue()) < 12;
  }

  OffscreenGl gl_{kSize};
  Renderer renderer_;
  DrawnScene scene_;
  CameraModel camera_;
  DrawList list_;
  const Vec3 p_WBall_{0, -0.1, 0};
};

TEST_F(Drawn, BodiesAppearInTheirColoursWhereTheyAre) {
  const QImage image = Image();
  EXPECT_TRUE(IsGreen(At(image, p_WBall_)));
  EXPECT_TRUE(IsGrey(At(image, {0.08, -0.02, 0.05})));
  EXPECT_LT(At(image, {0.08, -0.02, 0.05}).lightness(), 200);  // darker than
  EXPECT_GT(image.pixelColor(2, 2).lightness(), 220);          // the background
}

TEST_F(Drawn, AMovedPoseMovesThePixels) {
  list_.solids[kBallBody].X_W.p = Vec3(0.07, 0, 0.04);
  const QImage image = Image();
  EXPECT_FALSE(IsGreen(At(image, p_WBall_)));
  EXPECT_TRUE(IsGreen(At(image, p_WBall_ + Vec3(0.07, 0, 0.04))));
}

TEST_F(Drawn, NearerBodiesHideFartherBodies) {
  list_.solids[kBallBody].X_W.p = Vec3(0, 0.2, 0);  // behind the block
  EXPECT_TRUE(IsGrey(At(Image(), Vec3(0, -0.02, 0))));
}

TEST_F(Drawn, GhostBlendsWithItsBackground) {
  const Vec3 moved(0, 0, 0.02);
  const Vec3 p_WGhost = p_WBall_ + moved;
  list_.solids[kBallBody].X_W.p = Vec3(0, 0.2, 0);
  const QColor behind = At(Image(), p_WGhost);
  list_.ghosts = {{kBallBody, {Quat::Identity(), moved}, {0.0F, 0.2F, 1.0F}, 0.45F}};
  const QColor through = At(Image(), p_WGhost);
  list_.ghosts[0].opacity = 1.0F;
  const QColor opaque = At(Image(), p_WGhost);
  EXPECT_GT(opaque.blue(), behind.blue() + 20);
  EXPECT_LT(opaque.red(), behind.red() - 60);
  EXPECT_LT(through.red(), behind.red() - 20);
  EXPECT_GT(through.red(), opaque.red() + 20);
  // 45 % of the way, to the rounding of eight bits
  EXPECT_NEAR(through.red(), 0.55 * behind.red() + 0.45 * opaque.red(), 2.0);
  EXPECT_NEAR(through.green(), 0.55 * behind.green() + 0.45 * opaque.green(), 2.0);
}

TEST_F(Drawn, GhostAtTheSolidInstanceIsHidden) {
  const QImage alone = Image();
  list_.ghosts = {{kBallBody, {}, {0.0F, 0.2F, 1.0F}, 0.45F}};
  EXPECT_EQ(At(Image(), p_WBall_), At(alone, p_WBall_));
}

TEST_F(Drawn, NoInnerFaceShowsThroughAGhost) {
  // two walls of a box, one behind the other, give the same picture as the front wall alone
  DrawnScene box;
  box.bodies = {MakeDrawnBody("box", {}, BoxMesh({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}))};
  TriangleMesh front = BoxMesh({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05});
  front.triangles = {front.triangles[4], front.triangles[5]};
  DrawnScene wall;
  wall.bodies = {MakeDrawnBody("wall", {}, front)};
  list_.solids.clear();
  list_.ghosts = {{0, {}, {0.8F, 0.2F, 0.1F}, 0.45F}};
  renderer_.Upload(box.bodies);
  const QColor of_box = At(Image(), {0.01, -0.05, 0.02});
  renderer_.Upload(wall.bodies);
  EXPECT_EQ(of_box, At(Image(), {0.01, -0.05, 0.02}));
}

TEST_F(Drawn, ThePictureStaysOpaqueUnderGhosts) {
  list_.ghosts = {{kBallBody, {Quat::Identity(), Vec3(0.05, 0, 0)}, {0.0F, 0.2F, 1.0F}, 0.45F}};
  const QImage image = Image();
  int translucent = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x)
      translucent += image.pixelColor(x, y).alpha() < 255 ? 1 : 0;
  }
  EXPECT_EQ(translucent, 0);
}

TEST_F(Drawn, ProximityColoursABodysVerticesAndBringsOutNearVoxels) {
  const QImage before = Image();
  const Vec3 on_block(0.07, -0.02, 0.05);
  ProximityPicture proximity;
  proximity.bodies = {{kBallBody, {}}};
  for (const ShadedMesh::Vertex& v : scene_.bodies[kBallBody].mesh.vertices) {
    const std::uint8_t red = v.p[2] > 0 ? 255 : 0;  // the upper half red, the lower one blue
    proximity.bodies[0].rgba.push_back({red, 0, static_cast<std::uint8_t>(255 - red), 255});
  }
  proximity.voxel_size = 0.01F;
  proximity.shadow_W = {{0.07F, -0.02F, 0.05F}};
  renderer_.ShowProximity(&proximity);
  const QImage image = Image();
  const QColor above = At(image, p_WBall_ + Vec3(0, 0, 0.015));
  const QColor below = At(image, p_WBall_ - Vec3(0, 0, 0.015));
  EXPECT_GT(above.red(), above.blue() + 100);
  EXPECT_GT(below.blue(), below.red() + 100);
  const QColor voxel = At(image, on_block);
  EXPECT_GT(voxel.green(), voxel.red() + 40);
  EXPECT_TRUE(IsGrey(At(image, on_block + Vec3(0.01, 0, 0))));

  renderer_.ShowProximity(nullptr);
  EXPECT_EQ(Image(), before);
}

TEST_F(Drawn, CutTrianglesAreDrawnOnlyWithTheirVerticesColours) {
  const QImage uncut = Image();
  ShadedMesh& mesh = scene_.bodies[kBallBody].mesh;
  Refine(mesh, 0.004, 100'000);
  ASSERT_FALSE(mesh.uncut_triangles.empty());
  renderer_.Upload(scene_.bodies);
  EXPECT_EQ(Image(), uncut);
  // only vertices that the cuts made are red
  ProximityPicture proximity;
  proximity.bodies = {{kBallBody, {}}};
  proximity.bodies[0].rgba.assign(mesh.vertices.size(), {0, 0, 255, 255});
  const std::size_t first_new =
      scene_.bodies[kBallBody].file_triangles / 2 + 2;  // by Euler's formula
  for (std::size_t v = first_new; v < mesh.vertices.size(); ++v) {
    proximity.bodies[0].rgba[v] = {255, 0, 0, 255};
  }
  renderer_.ShowProximity(&proximity);
  const QImage coloured = Image();
  int red = 0;
  for (int y = 0; y < coloured.height(); ++y) {
    for (int x = 0; x < coloured.width(); ++x) {
      const QColor c = coloured.pixelColor(x, y);
      red += c.red() > c.blue() + 60 ? 1 : 0;
    }
  }
  EXPECT_GT(red, 100);
}

TEST_F(Drawn, VertexColoursOfAnotherSceneAreIgnored) {
  const QImage before = Image();
  ProximityPicture proximity;
  proximity.bodies = {{kBallBody, {{255, 0, 0, 255}}}, {9, {{255, 0, 0, 255}}}};
  renderer_.ShowProximity(&proximity);
  EXPECT_EQ(Image(), before);
}

TEST_F(Drawn, UnknownBodiesAreIgnored) {
  const QImage before = Image();
  list_.solids.push_back({9, {}, {1, 0, 0}, 1});
  list_.ghosts = {{9, {}, {1, 0, 0}, 0.5F}};
  EXPECT_EQ(Image(), before);
}

}  // namespace
}  // namespace tandem
