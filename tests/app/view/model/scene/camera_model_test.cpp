#include "app/view/model/scene/camera_model.h"

#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kQuarterTurnPx = 180;

CameraModel CameraOn(const Bounds& bounds_W, int width = 800, int height = 600) {
  CameraModel camera;
  camera.SetViewport(width, height);
  camera.LookFrom(StandardView::kIso);
  camera.Fit(bounds_W);
  return camera;
}

Bounds Box(const Vec3& min, const Vec3& max) {
  Bounds box;
  box.Add(min);
  box.Add(max);
  return box;
}

/// Computes the same answer by the matrices that OpenGL uses.
Vec2 ProjectByMatrices(const CameraModel& camera, const Vec3& p_W) {
  const Eigen::Vector4d clip = camera.Projection() * camera.ViewFromWorld() * p_W.homogeneous();
  return {(0.5 + 0.5 * clip.x() / clip.w()) * camera.width_px(),
          (0.5 - 0.5 * clip.y() / clip.w()) * camera.height_px()};
}

TEST(CameraModel, FitsTheWholeBoxIntoThePictureWhateverItsShape) {
  const std::vector<Bounds> boxes{Box({-1, -1, -1}, {1, 1, 1}), Box({0, 0, 0}, {0.7, 0.05, 0.05}),
                                  Box({5, 5, 5}, {5.01, 5.01, 7}), Box({0, 0, 0}, {100, 80, 1})};
  for (const Bounds& box : boxes) {
    for (const auto& [width, height] : std::vector<std::pair<int, int>>{{800, 600}, {300, 900}}) {
      const CameraModel camera = CameraOn(box, width, height);
      double closest_to_rim = 1e9;
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p((corner & 1) != 0 ? box.max.x() : box.min.x(),
                     (corner & 2) != 0 ? box.max.y() : box.min.y(),
                     (corner & 4) != 0 ? box.max.z() : box.min.z());
        const auto px = camera.Project(p);
        ASSERT_TRUE(px.has_value());
        closest_to_rim = std::min({closest_to_rim, px->x() / width, 1 - px->x() / width,
                                   px->y() / height, 1 - px->y() / height});
      }
      EXPECT_GE(closest_to_rim, 0.0);
      EXPECT_LE(closest_to_rim, 0.1);  // and does not stand needlessly far away
    }
  }
}

TEST(CameraModel, ProjectsAsItsMatricesDo) {
  const CameraModel camera = CameraOn(Box({-0.2, -0.1, 0}, {0.3, 0.1, 0.2}));
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(0.3, 0.1, 0.2), Vec3(-0.2, 0.05, 0.1)}) {
    const auto px = camera.Project(p);
    ASSERT_TRUE(px.has_value());
    EXPECT_LT((*px - ProjectByMatrices(camera, p)).norm(), 1e-6);
  }
}

TEST(CameraModel, PointBehindTheEyeHasNoPixel) {
  const CameraModel camera = CameraOn(Box({-1, -1, -1}, {1, 1, 1}));
  const Vec3 behind = camera.eye_W() + 0.5 * (camera.eye_W() - camera.target_W());
  EXPECT_FALSE(camera.Project(behind).has_value());
}

TEST(CameraModel, ZoomKeepsThePointUnderTheCursor) {
  CameraModel camera = CameraOn(Box({-1, -1, -1}, {1, 1, 1}));
  const Vec2 cursor(130, 470);
  const Vec3 p_W = camera.PointAtTargetDepth(cursor);
  const double before = camera.distance();
  camera.ZoomAt(cursor, 3);
  EXPECT_LT(camera.distance(), before);
  EXPECT_LT((*camera.Project(p_W) - cursor).norm(), 1e-6);
  camera.ZoomAt(cursor, -5);
  EXPECT_GT(camera.distance(), before);
  EXPECT_LT((*camera.Project(p_W) - cursor).norm(), 1e-6);
}

TEST(CameraModel, PansWithTheMouse) {
  CameraModel camera = CameraOn(Box({-1, -1, -1}, {1, 1, 1}));
  const Vec3 p_W = camera.PointAtTargetDepth({200, 200});
  camera.Pan(37, -12);
  EXPECT_LT((*camera.Project(p_W) - Vec2(237, 188)).norm(), 1e-6);
}

TEST(CameraModel, OrbitsAboutTheTargetWithZUp) {
  CameraModel camera = CameraOn(Box({-1, -1, -1}, {1, 1, 1}));
  const double distance = (camera.eye_W() - camera.target_W()).norm();
  camera.Orbit(77, -33);
  EXPECT_NEAR((camera.eye_W() - camera.target_W()).norm(), distance, 1e-9);
  EXPECT_LT((*camera.Project(camera.target_W()) - Vec2(400, 300)).norm(), 1e-6);
  EXPECT_NEAR(camera.R_WC().col(0).z(), 0.0, 1e-12);  // the horizon stays level
}

TEST(CameraModel, StopsAtThePoles) {
  CameraModel camera = CameraOn(Box({-1, -1, -1}, {1, 1, 1}));
  camera.Orbit(0, 100 * kQuarterTurnPx);
  EXPECT_NEAR(camera.elevation(), std::acos(0.0), 1e-12);
  EXPECT_NEAR(camera.R_WC().determinant(), 1.0, 1e-12);
}

TEST(CameraModel, LooksAlongTheAxesFromTheStandardViews) {
  CameraModel camera = CameraOn(Box({-1, -1, -1}, {1, 1, 1}));
  camera.LookFrom(StandardView::kFront);  // X to the right, Z up, the eye at -Y
  EXPECT_LT((camera.R_WC().col(0) - Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((camera.R_WC().col(1) - Vec3::UnitZ()).norm(), 1e-12);
  camera.LookFrom(StandardView::kRight);  // Y to the right, the eye at +X
  EXPECT_LT((camera.R_WC().col(0) - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_LT((camera.R_WC().col(2) - Vec3::UnitX()).norm(), 1e-12);
  camera.LookFrom(StandardView::kTop);  // X to the right, Y up, the eye at +Z
  EXPECT_LT((camera.R_WC().col(1) - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_LT((camera.R_WC().col(2) - Vec3::UnitZ()).norm(), 1e-12);
}

TEST(CameraModel, KeepsBothTheSceneAndBodiesFarOutsideItBetweenItsPlanes) {
  const Bounds box = Box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  const CameraModel camera = CameraOn(box);
  for (const double along : {-0.3, 0.0, 1.0}) {  // m; distance from the target away from the eye
    const Vec3 p = camera.target_W() - along * camera.R_WC().col(2);
    const Eigen::Vector4d clip = camera.Projection() * camera.ViewFromWorld() * p.homogeneous();
    EXPECT_LT(std::abs(clip.z() / clip.w()), 1.0) << along;
  }
}

}  // namespace
}  // namespace tandem
