#include "app/view/model/hand/part_drag.h"

#include <numbers>

#include <gtest/gtest.h>

#include "app/view/model/hand/triad.h"

namespace tandem {
namespace {

/// Returns a camera before a scene of 20 cm, from the front (along +Y) unless said.
CameraModel FrontCamera(StandardView from = StandardView::kFront) {
  CameraModel camera;
  camera.SetViewport(800, 600);
  camera.LookFrom(from);
  Bounds box;
  box.Add(Vec3(-0.1, -0.1, -0.1));
  box.Add(Vec3(0.1, 0.1, 0.1));
  camera.Fit(box);
  return camera;
}

const Pose kPart{RotationBy(Vec3(0.2, -0.4, 0.1)), Vec3(0.02, -0.03, 0.01)};

PartDrag Grabbed(const CameraModel& camera, const Vec3& p_W) {
  PartDrag drag;
  drag.Begin(*camera.Project(p_W), p_W, kPart);
  return drag;
}

double AngleBetween(const Pose& a, const Pose& b) {
  return RotationVector(a.q * b.q.conjugate()).norm();
}

TEST(PartDrag, KeepsTheGrabbedPointUnderTheCursor) {
  for (const StandardView from : {StandardView::kFront, StandardView::kTop, StandardView::kIso}) {
    const CameraModel camera = FrontCamera(from);
    const Vec3 p_W(0.03, -0.06, 0.02);
    PartDrag drag = Grabbed(camera, p_W);
    for (const Vec2& px : {Vec2(500, 200), Vec2(120, 480), Vec2(640, 90)}) {
      drag.Follow(camera, px, {});
      EXPECT_LT((*camera.Project(drag.point_W()) - px).norm(), 1e-6);
      EXPECT_NEAR((drag.point_W() - p_W).dot(camera.R_WC().col(2)), 0, 1e-12);
      EXPECT_LT(AngleBetween(drag.goal(), kPart), 1e-12);
      EXPECT_LT((drag.goal().p - kPart.p - (drag.point_W() - p_W)).norm(), 1e-12);
    }
    drag.Follow(camera, *camera.Project(p_W), {});
    EXPECT_LT((drag.goal().p - kPart.p).norm(), 1e-12);  // back where it was
  }
}

TEST(PartDrag, TheWheelMovesInDepthAndLeavesThePointUnderTheCursor) {
  const CameraModel camera = FrontCamera(StandardView::kIso);
  PartDrag drag = Grabbed(camera, {0.03, -0.06, 0.02});
  drag.Follow(camera, {520, 230}, {});
  const double before = (drag.point_W() - camera.eye_W()).norm();
  drag.Wheel(camera, 3, {});
  EXPECT_GT((drag.point_W() - camera.eye_W()).norm(), 1.05 * before);
  EXPECT_LT((*camera.Project(drag.point_W()) - Vec2(520, 230)).norm(), 1e-6);
  drag.Wheel(camera, -3, {});
  EXPECT_NEAR((drag.point_W() - camera.eye_W()).norm(), before, 1e-9);
  drag.Wheel(camera, -1000, {});  // however wildly it is turned
  EXPECT_TRUE(camera.Project(drag.point_W()).has_value());
}

TEST(PartDrag, ShiftMovesAtATenthOfTheSpeed) {
  const CameraModel camera = FrontCamera();
  const Vec3 p_W(0.0, -0.05, 0.0);
  PartDrag fast = Grabbed(camera, p_W);
  PartDrag fine = Grabbed(camera, p_W);
  const Vec2 to = *camera.Project(p_W) + Vec2(100, -40);
  fast.Follow(camera, to, {});
  fine.Follow(camera, to, {.fine = true});
  EXPECT_LT((10 * (fine.goal().p - kPart.p) - (fast.goal().p - kPart.p)).norm(), 1e-9);
  fine.Wheel(camera, 10, {.fine = true});
  fast.Wheel(camera, 1, {});
  EXPECT_NEAR(fine.goal().p.y() - kPart.p.y(), fast.goal().p.y() - kPart.p.y(), 1e-9);
}

TEST(PartDrag, RotationKeepsTheGrabbedPoint) {
  const CameraModel camera = FrontCamera();
  const Vec3 p_W(0.03, -0.06, 0.02);
  PartDrag drag = Grabbed(camera, p_W);
  drag.Follow(camera, *camera.Project(p_W) + Vec2(90, 0), {.turn = true});
  EXPECT_LT((drag.point_W() - p_W).norm(), 1e-12);
  EXPECT_LT((drag.goal() * (kPart.Inverse() * p_W) - p_W).norm(), 1e-12);
  // 90 px to the right are 45 degrees about the picture's up, which is Z: the front goes right
  const Vec3 turned = RotationVector(drag.goal().q * kPart.q.conjugate());
  EXPECT_LT((turned - Vec3(0, 0, 0.25 * std::numbers::pi)).norm(), 1e-9);
}

TEST(PartDrag, DownwardDragRotatesTheTopTowardsTheViewer) {
  const CameraModel camera = FrontCamera();
  const Vec3 p_W(0, 0, 0);
  PartDrag drag = Grabbed(camera, p_W);
  drag.Follow(camera, *camera.Project(p_W) + Vec2(0, 60), {.turn = true});
  const Vec3 upper = (drag.goal() * kPart.Inverse()) * Vec3(0, 0, 0.1);
  EXPECT_LT(upper.y(), -0.02);  // the eye is at -Y
}

TEST(PartDrag, AxisLockProjectsTheCursorOntoTheAxis) {
  const CameraModel camera = FrontCamera(StandardView::kIso);
  const Vec3 p_W(0.03, -0.06, 0.02);
  for (int axis = 0; axis < 3; ++axis) {
    PartDrag drag = Grabbed(camera, p_W);
    drag.Lock(AxisLock{axis});
    // the cursor goes to where the point of the axis at 4 cm is seen
    const Vec3 wanted = p_W + 0.04 * Vec3::Unit(axis);
    drag.Follow(camera, *camera.Project(wanted), {});
    EXPECT_LT((drag.point_W() - wanted).norm(), 1e-9) << axis;
    // the cursor goes anywhere: the part never leaves the axis
    drag.Follow(camera, {650, 80}, {});
    EXPECT_LT(Vec3::Unit(axis).cross(drag.point_W() - p_W).norm(), 1e-12) << axis;
  }
}

TEST(PartDrag, PlaneLockKeepsToThePlane) {
  const CameraModel camera = FrontCamera(StandardView::kIso);
  const Vec3 p_W(0.03, -0.06, 0.02);
  PartDrag drag = Grabbed(camera, p_W);
  drag.Lock(AxisLock{2, true});
  const Vec3 wanted = p_W + Vec3(0.02, 0.05, 0);
  drag.Follow(camera, *camera.Project(wanted), {});
  EXPECT_LT((drag.point_W() - wanted).norm(), 1e-9);
  drag.Wheel(camera, 2, {});
  EXPECT_NEAR(drag.point_W().z(), p_W.z(), 1e-12);
}

TEST(PartDrag, PartLockFollowsThePartsAxis) {
  const CameraModel camera = FrontCamera(StandardView::kIso);
  const Vec3 p_W(0.03, -0.06, 0.02);
  PartDrag drag = Grabbed(camera, p_W);
  drag.Lock(AxisLock{0, false, true});
  drag.Follow(camera, {600, 300}, {});
  const Vec3 moved = drag.point_W() - p_W;
  EXPECT_GT(moved.norm(), 1e-3);
  EXPECT_LT(moved.cross(kPart.q * Vec3::UnitX()).norm(), 1e-12);
}

TEST(PartDrag, AxisTowardsTheEyeFollowsVerticalMotion) {
  const CameraModel camera = FrontCamera();
  const Vec3 p_W = camera.target_W();
  PartDrag drag = Grabbed(camera, p_W);
  drag.Lock(AxisLock{1});
  drag.Follow(camera, *camera.Project(p_W) + Vec2(0, 50), {});
  const Vec3 moved = drag.point_W() - p_W;
  EXPECT_NEAR(moved.y(), -50 * camera.MetresPerPixelAt(p_W), 1e-9);  // down: towards the eye
  EXPECT_LT(Vec2(moved.x(), moved.z()).norm(), 1e-12);
}

TEST(PartDrag, LockedRotationIsAboutItsAxis) {
  const CameraModel camera = FrontCamera(StandardView::kIso);
  const Vec3 p_W(0.03, -0.06, 0.02);
  for (int axis = 0; axis < 3; ++axis) {
    PartDrag drag = Grabbed(camera, p_W);
    drag.Lock(AxisLock{axis});
    drag.Follow(camera, *camera.Project(p_W) + Vec2(60, 35), {.turn = true});
    const Vec3 turned = RotationVector(drag.goal().q * kPart.q.conjugate());
    EXPECT_GT(turned.norm(), 0.05) << axis;
    EXPECT_LT(turned.cross(Vec3::Unit(axis)).norm(), 1e-9) << axis;
  }
}

TEST(PartDrag, NudgesFollowThePictureOrTheLockedAxis) {
  const CameraModel camera = FrontCamera();
  PartDrag drag = Grabbed(camera, {0, 0, 0});
  drag.Nudge(camera, {0.001, 0, 0});
  EXPECT_LT((drag.goal().p - kPart.p - Vec3(0.001, 0, 0)).norm(), 1e-12);
  drag.Nudge(camera, {0, 0, -0.002});  // away from the eye
  EXPECT_LT((drag.goal().p - kPart.p - Vec3(0.001, 0.002, 0)).norm(), 1e-12);
  drag.Lock(AxisLock{2});
  drag.Nudge(camera, {0, 0.001, 0});
  EXPECT_LT((drag.goal().p - kPart.p - Vec3(0.001, 0.002, 0.001)).norm(), 1e-12);
  drag.Lock({});
  drag.NudgeTurn(camera, {0, 0.1, 0});
  EXPECT_NEAR(AngleBetween(drag.goal(), kPart), 0.1, 1e-12);
  EXPECT_LT((drag.goal() * (kPart.Inverse() * Vec3::Zero()) - drag.point_W()).norm(), 1e-12);
}

TEST(PartDrag, ContinuesFromAReturnedGoal) {
  const CameraModel camera = FrontCamera();
  const Vec3 p_W(0.03, -0.06, 0.02);
  PartDrag drag = Grabbed(camera, p_W);
  drag.Follow(camera, {600, 300}, {});
  drag.GoOnFrom(kPart);
  EXPECT_LT((drag.point_W() - p_W).norm(), 1e-12);
  drag.Follow(camera, {600, 300}, {});  // the mouse has not moved
  EXPECT_LT((drag.goal().p - kPart.p).norm(), 1e-12);
}

TEST(PartDrag, AxisKeyCyclesWorldPartAndNone) {
  auto lock = NextLock({}, 0, false);
  EXPECT_EQ(lock, (AxisLock{0, false, false}));
  lock = NextLock(lock, 0, false);
  EXPECT_EQ(lock, (AxisLock{0, false, true}));
  EXPECT_EQ(NextLock(lock, 0, false), std::nullopt);
  EXPECT_EQ(NextLock(lock, 1, false), (AxisLock{1, false, false}));
  EXPECT_EQ(NextLock(lock, 0, true), (AxisLock{0, true, false}));
}

TEST(Triad, IsPickedOnlyAtItsHandles) {
  const CameraModel camera = FrontCamera(StandardView::kIso);
  const Pose at{Quat::Identity(), Vec3(0.02, 0.01, -0.03)};
  const auto picture = DrawTriad(camera, at);
  ASSERT_TRUE(picture.has_value());
  using Kind = TriadHandle::Kind;
  const double m = picture->metres_per_px;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 tip = at.p + 0.9 * TriadPicture::kArrowPx * m * Vec3::Unit(axis);
    EXPECT_EQ(PickTriad(*picture, *camera.Project(tip)), (TriadHandle{Kind::kArrow, axis}));
    const double middle =
        0.5 * (TriadPicture::kSquareFrom + TriadPicture::kSquareTo) * TriadPicture::kArrowPx * m;
    const Vec3 in_square =
        at.p + middle * (Vec3::Unit((axis + 1) % 3) + Vec3::Unit((axis + 2) % 3));
    EXPECT_EQ(PickTriad(*picture, *camera.Project(in_square)), (TriadHandle{Kind::kSquare, axis}));
  }
  EXPECT_EQ(PickTriad(*picture, picture->origin), std::nullopt);
  EXPECT_EQ(PickTriad(*picture, picture->origin + Vec2(150, 150)), std::nullopt);
}

TEST(Triad, HasAConstantScreenSize) {
  CameraModel camera = FrontCamera();
  for (int zoom = 0; zoom < 3; ++zoom) {
    const auto picture = DrawTriad(camera, {});
    ASSERT_TRUE(picture.has_value());
    EXPECT_NEAR((picture->arrows[0].to - picture->origin).norm(), TriadPicture::kArrowPx, 1e-6);
    camera.ZoomAt({400, 300}, 4);
  }
}

TEST(Triad, ArrowMovesAlongItsAxisAndRingFollowsTheCursor) {
  const CameraModel camera = FrontCamera(StandardView::kIso);
  const Pose at{Quat::Identity(), Vec3(0.02, 0.01, -0.03)};
  PartDrag drag;
  const TriadHandle arrow{TriadHandle::Kind::kArrow, 1};
  const Vec2 tip = DrawTriad(camera, at)->arrows[1].to;
  DragManner manner = BeginByHandle(camera, at, arrow, false, tip, kPart, drag);
  EXPECT_FALSE(manner.turn);
  drag.Follow(camera, tip + Vec2(40, -25), manner);
  EXPECT_GT((drag.goal().p - kPart.p).norm(), 1e-3);
  EXPECT_LT((drag.goal().p - kPart.p).cross(Vec3::UnitY()).norm(), 1e-12);

  // a small turn takes the ring's point along with the cursor
  const double radius = TriadPicture::kRingPx * camera.MetresPerPixelAt(at.p);
  const Vec3 to_eye = camera.eye_W() - at.p;
  const Vec3 r = Vec3(to_eye.x(), to_eye.y(), 0).normalized();
  const Vec2 pressed = *camera.Project(at.p + radius * r);
  manner = BeginByHandle(camera, at, {TriadHandle::Kind::kRing, 2}, false, pressed, kPart, drag);
  EXPECT_TRUE(manner.turn);
  const Vec2 target = *camera.Project(at.p + radius * (RotationBy(Vec3(0, 0, 0.05)) * r));
  drag.Follow(camera, target, manner);
  const Vec3 turned = RotationVector(drag.goal().q * kPart.q.conjugate());
  EXPECT_NEAR(turned.z(), 0.05, 0.002);
  EXPECT_LT(Vec2(turned.x(), turned.y()).norm(), 1e-12);
}

}  // namespace
}  // namespace tandem
