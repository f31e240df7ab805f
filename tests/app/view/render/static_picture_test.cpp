#include "app/view/render/static_picture.h"

#include <array>

#include <gtest/gtest.h>

#include "app/view/render/renderer.h"
#include "tests/app/view/render/offscreen_gl.h"
#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

constexpr std::size_t kFixed = 0;
constexpr std::size_t kMoving = 1;
constexpr QSize kPictureSize(320, 240);
constexpr QSize kOtherSize(300, 240);

const Renderer::MayGoOn kNoTime = [] {
  return false;
};

/// A renderer that keeps its static picture, and a second that never has one to reuse.
class KeptPicture : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(gl_.ready()) << "no OpenGL: run under xvfb-run";
    ASSERT_FALSE(renderer_.Initialize().has_value());
    Show(BlockAndBall());
    Look(kPictureSize);
  }
  void Show(DrawnScene scene) {
    scene_ = std::move(scene);
    renderer_.Upload(scene_.bodies);
    list_ = {};
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      list_.solids.push_back({i, {}, scene_.bodies[i].look.colour, 1});
    }
  }
  void Look(const QSize& size) {
    camera_.SetViewport(size.width(), size.height());
    camera_.LookFrom(StandardView::kIso);
    camera_.Fit(scene_.BoundsOfAll());
  }
  QImage Image() { return gl_.Draw(renderer_, camera_, list_); }
  QImage FullRedraw() {
    Renderer anew;
    EXPECT_FALSE(anew.Initialize().has_value());
    anew.Upload(scene_.bodies);
    anew.ShowProximity(proximity_.get());
    return gl_.Draw(anew, camera_, list_);
  }
  /// Draws a frame, and tells whether it began a static picture.
  bool DrawsAnew() {
    const std::uint64_t before = renderer_.static_pictures();
    EXPECT_EQ(Image(), FullRedraw());
    return renderer_.static_pictures() != before;
  }
  void MoveBall(const Vec3& to) { list_.solids[kMoving].X_W.p = to; }

  OffscreenGl gl_{kPictureSize, GetParam()};
  Renderer renderer_;
  DrawnScene scene_;
  CameraModel camera_;
  DrawList list_;
  std::unique_ptr<ProximityPicture> proximity_;
};

/// Returns a large ball, fixed, and the one that moves, both smooth.
DrawnScene TwoBalls() {
  DrawnScene scene = BlockAndBall();
  scene.bodies[kFixed] =
      MakeDrawnBody("fixed ball", {true, {0.6F, 0.6F, 0.6F}}, SphereMesh(0.06, 24, 48));
  return scene;
}

// the way goes from before the fixed body, past its side, to behind it
const std::array<Vec3, 5> kWay{Vec3(0, 0, 0), Vec3(0.05, 0.08, 0.03), Vec3(0.09, 0.1, 0.09),
                               Vec3(0, 0.2, 0), Vec3(-0.11, 0.13, 0.09)};

TEST_P(KeptPicture, IsReusedWhileBodiesMoveAndEqualsAFullRedraw) {
  EXPECT_TRUE(DrawsAnew());
  QImage before;
  for (const Vec3& at : kWay) {
    MoveBall(at);
    EXPECT_FALSE(DrawsAnew());
    const QImage now = Image();
    EXPECT_NE(now, before);
    before = now;
  }
}

TEST_P(KeptPicture, HidesMovingBodiesAsAFullRedrawDoes) {
  // smooth balls have no edges, so that the order of drawing changes no pixel; the same scene
  // without a fixed body has no static picture
  Show(TwoBalls());
  DrawnScene free = TwoBalls();
  free.bodies[kFixed].look.fixed = false;
  Renderer at_once;
  ASSERT_FALSE(at_once.Initialize().has_value());
  at_once.Upload(free.bodies);
  for (const Vec3& at : kWay) {
    MoveBall(at);
    EXPECT_EQ(Image(), gl_.Draw(at_once, camera_, list_));
  }
}

TEST_P(KeptPicture, GhostsAndNearVoxelsAreNotKept) {
  const QImage before = Image();
  proximity_ = std::make_unique<ProximityPicture>();
  proximity_->voxel_size = 0.01F;
  proximity_->shadow_W = {{0.07F, -0.02F, 0.05F}};
  renderer_.ShowProximity(proximity_.get());
  list_.ghosts = {{kMoving, {Quat::Identity(), Vec3(0.05, 0, 0)}, {0.0F, 0.2F, 1.0F}, 0.45F}};
  EXPECT_FALSE(DrawsAnew());
  EXPECT_NE(Image(), before);
  list_.ghosts.clear();
  proximity_.reset();
  renderer_.ShowProximity(nullptr);
  EXPECT_FALSE(DrawsAnew());
  EXPECT_EQ(Image(), before);
}

TEST_P(KeptPicture, IsDrawnAgainWhenTheEyeTurns) {
  Image();
  camera_.Orbit(1, 0);
  EXPECT_TRUE(DrawsAnew());
  EXPECT_FALSE(DrawsAnew());
}

TEST_P(KeptPicture, IsDrawnAgainWhenTheEyeComesNearer) {
  Image();
  camera_.ZoomAt({160, 120}, 0.2);
  EXPECT_TRUE(DrawsAnew());
}

TEST_P(KeptPicture, IsDrawnAgainWhenTheProjectionAloneChanges) {
  Image();
  camera_.SetViewport(kOtherSize.width(), kOtherSize.height());
  EXPECT_TRUE(DrawsAnew());
}

TEST_P(KeptPicture, IsDrawnAgainInAnotherSize) {
  Image();
  gl_.SetTarget(kOtherSize, GetParam());
  EXPECT_TRUE(DrawsAnew());
  EXPECT_EQ(Image().size(), kOtherSize);
}

TEST_P(KeptPicture, IsDrawnAgainForAnotherFormatOfDepth) {
  Image();
  MoveBall(kWay[1]);
  gl_.SetTarget(kPictureSize, GetParam(), QOpenGLFramebufferObject::CombinedDepthStencil);
  EXPECT_TRUE(DrawsAnew());
}

TEST_P(KeptPicture, IsKeptPerSampleCount) {
  const int other = GetParam() == 0 ? 4 : 0;
  EXPECT_TRUE(DrawsAnew());
  gl_.SetTarget(kPictureSize, other);
  EXPECT_TRUE(DrawsAnew());
  gl_.SetTarget(kPictureSize, GetParam());
  EXPECT_FALSE(DrawsAnew());
  gl_.SetTarget(kPictureSize, other);
  EXPECT_FALSE(DrawsAnew());
}

TEST_P(KeptPicture, IsDrawnAgainInAnotherColour) {
  Image();
  list_.solids[kFixed].colour = {0.7F, 0.3F, 0.3F};
  EXPECT_TRUE(DrawsAnew());
}

TEST_P(KeptPicture, IsDrawnAgainWhenAFixedBodyStandsElsewhere) {
  Image();
  list_.solids[kFixed].X_W.p = Vec3(0.01, 0, 0);
  EXPECT_TRUE(DrawsAnew());
}

TEST_P(KeptPicture, IsDrawnAgainWhenAFixedBodyIsHiddenOrShown) {
  const QImage before = Image();
  const DrawList all = list_;
  list_.solids.erase(list_.solids.begin());
  EXPECT_TRUE(DrawsAnew());
  EXPECT_NE(Image(), before);
  list_ = all;
  EXPECT_TRUE(DrawsAnew());
  EXPECT_EQ(Image(), before);
}

TEST_P(KeptPicture, IsDrawnAgainWhenAFixedBodysVerticesAreColoured) {
  const QImage before = Image();
  for (const std::uint8_t red : {std::uint8_t{255}, std::uint8_t{90}}) {
    proximity_ = std::make_unique<ProximityPicture>();
    const std::size_t vertices = scene_.bodies[kFixed].mesh.vertices.size();
    proximity_->bodies = {{kFixed, {}}};
    proximity_->bodies[0].rgba.assign(vertices, {red, 0, 0, 255});
    renderer_.ShowProximity(proximity_.get());
    EXPECT_TRUE(DrawsAnew());
    EXPECT_NE(Image(), before);
  }
  proximity_.reset();
  renderer_.ShowProximity(nullptr);
  EXPECT_TRUE(DrawsAnew());
  EXPECT_EQ(Image(), before);
}

TEST_P(KeptPicture, IsDrawnAgainForAnotherScene) {
  Image();
  const DrawList same = list_;
  Show(TwoBalls());
  list_ = same;
  EXPECT_TRUE(DrawsAnew());
}

/// Returns a scene with a fixed ball of four pieces that comes out of the block.
DrawnScene LargeScene() {
  DrawnScene scene = BlockAndBall();
  scene.bodies.push_back(
      MakeDrawnBody("large", {true, {0.5F, 0.5F, 0.7F}}, SphereMesh(0.06, 201, 128)));
  return scene;
}

TEST_P(KeptPicture, RefinesFrameByFrameToTheFullPicture) {
  Show(LargeScene());
  const QImage full = FullRedraw();
  QImage before;
  int frames_in_part = 0;
  for (; frames_in_part < 20; ++frames_in_part) {
    const auto [image, whole] = gl_.DrawInPart(renderer_, camera_, list_, kNoTime);
    EXPECT_EQ(image == full, whole);
    if (whole) break;
    EXPECT_NE(image, before);
    before = image;
  }
  // four pieces of the ball, one frame each; the block comes with the first
  EXPECT_EQ(frames_in_part, 3);
  EXPECT_EQ(renderer_.static_pictures(), 1U);
}

TEST_P(KeptPicture, RefinesWithinItsTimeBudget) {
  Show(LargeScene());
  int requested = 0;
  const auto twice = [&requested] {
    return ++requested < 2;
  };
  EXPECT_FALSE(gl_.DrawInPart(renderer_, camera_, list_, twice).second);
  EXPECT_EQ(requested, 2);
  EXPECT_TRUE(gl_.DrawInPart(renderer_, camera_, list_, {}).second);
}

TEST_P(KeptPicture, RestartsRefinementWhenTheEyeMoves) {
  Show(LargeScene());
  for (int i = 0; i < 10; ++i) {
    camera_.Orbit(1, 0);
    EXPECT_FALSE(gl_.DrawInPart(renderer_, camera_, list_, kNoTime).second);
  }
  EXPECT_EQ(Image(), FullRedraw());
}

TEST_P(KeptPicture, IsCompleteAtOnceForASmallScene) {
  const auto [image, whole] = gl_.DrawInPart(renderer_, camera_, list_, kNoTime);
  EXPECT_TRUE(whole);
  EXPECT_EQ(image, FullRedraw());
}

INSTANTIATE_TEST_SUITE_P(Samples, KeptPicture, ::testing::Values(0, 4));

}  // namespace
}  // namespace tandem
