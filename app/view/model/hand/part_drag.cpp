#include "app/view/model/hand/part_drag.h"

#include <cmath>

namespace tandem {

namespace {

constexpr double kGrazing = 0.12;     // sine of 7 degrees; a plane seen more flatly is unusable
constexpr double kNearestStep = 0.2;  // smallest factor on the distance to the eye for one event of
                                      // the wheel

/// Returns the point at which a ray meets the plane at `p_W` with normal `n_W`. Where the plane is
/// seen too flatly, uses the plane parallel to the picture.
Vec3 ThroughPlane(const Ray& ray, const Vec3& p_W, const Vec3& n_W, const Vec3& towards_eye_W) {
  const bool flat = std::abs(ray.along_W.dot(n_W)) < kGrazing;
  const Vec3 n = flat ? towards_eye_W : n_W;
  return ray.from_W + ((p_W - ray.from_W).dot(n) / ray.along_W.dot(n)) * ray.along_W;
}

/// Returns the position along the line through `p_W` that is nearest to a ray, which must not be
/// parallel.
double AlongLine(const Ray& ray, const Vec3& p_W, const Vec3& axis_W) {
  const double c = axis_W.dot(ray.along_W);
  const Vec3 to_eye = ray.from_W - p_W;
  return (to_eye.dot(axis_W) - c * to_eye.dot(ray.along_W)) / (1 - c * c);
}

}  // namespace

void PartDrag::Begin(const Vec2& cursor_px, const Vec3& p_W, const Pose& X_WG) {
  cursor_px_ = cursor_px;
  p_W_ = p_W;
  X_WG_ = X_WG;
  ring_px_ = Vec2::Zero();
}

void PartDrag::GoOnFrom(const Pose& X_WG) {
  p_W_ = X_WG * (X_WG_.Inverse() * p_W_);
  X_WG_ = X_WG;
}

std::optional<Vec3> PartDrag::AxisOfLock() const {
  if (!lock_) return std::nullopt;
  const Vec3 axis = Vec3::Unit(lock_->axis);
  return lock_->of_part ? Vec3(X_WG_.q * axis) : axis;
}

void PartDrag::MoveBy(const Vec3& by_W) {
  p_W_ += by_W;
  X_WG_.p += by_W;
}

void PartDrag::TurnBy(const Vec3& by_W) {
  const Quat turn = RotationBy(by_W);
  X_WG_.p = p_W_ + turn * (X_WG_.p - p_W_);
  X_WG_.q = (turn * X_WG_.q).normalized();
}

Vec3 PartDrag::MotionUnderCursor(const CameraModel& camera, const Vec2& from_px,
                                 const Vec2& to_px) const {
  const Ray from = camera.RayThrough(from_px);
  const Ray to = camera.RayThrough(to_px);
  const Vec3 towards_eye = camera.R_WC().col(2);
  const std::optional<Vec3> axis = AxisOfLock();
  if (!axis || lock_->plane) {
    const Vec3 n = axis.value_or(towards_eye);
    return ThroughPlane(to, p_W_, n, towards_eye) - ThroughPlane(from, p_W_, n, towards_eye);
  }
  // an axis that points at the eye is a dot in the picture: vertical motion moves along it
  const double across = axis->cross(from.along_W).norm();
  if (across < kGrazing) {
    const double sign = axis->dot(towards_eye) > 0 ? 1 : -1;
    return (sign * camera.MetresPerPixelAt(p_W_) * (to_px.y() - from_px.y())) * *axis;
  }
  return (AlongLine(to, p_W_, *axis) - AlongLine(from, p_W_, *axis)) * *axis;
}

Vec3 PartDrag::TurnUnderCursor(const CameraModel& camera, const Vec2& by_px) const {
  const Mat3 R = camera.R_WC();
  const std::optional<Vec3> axis = AxisOfLock();
  if (!axis) return kTurnPerPixel * (by_px.x() * R.col(1) + by_px.y() * R.col(0));
  if (!ring_px_.isZero()) return (ring_px_.dot(by_px) / px_per_rad_) * *axis;
  // the near side of the part moves with the mouse; for an axis along the line of sight a motion to
  // the right turns clockwise
  const Vec3 moved = axis->cross(R.col(2));
  const Vec2 along(R.col(0).dot(moved), -R.col(1).dot(moved));
  if (along.norm() < kGrazing) {
    const double sign = axis->dot(R.col(2)) > 0 ? -1 : 1;
    return (sign * kTurnPerPixel * by_px.x()) * *axis;
  }
  return (kTurnPerPixel * along.normalized().dot(by_px)) * *axis;
}

void PartDrag::Follow(const CameraModel& camera, const Vec2& cursor_px, const DragManner& manner) {
  const Vec2 before = cursor_px_;
  cursor_px_ = cursor_px;
  const double speed = manner.fine ? kFine : 1.0;
  if (manner.turn) {
    TurnBy(speed * TurnUnderCursor(camera, cursor_px - before));
  } else {
    MoveBy(speed * MotionUnderCursor(camera, before, cursor_px));
  }
}

void PartDrag::Wheel(const CameraModel& camera, double steps, const DragManner& manner) {
  const double by = steps * (manner.fine ? kFine : 1.0);
  const Vec3 towards_eye = camera.R_WC().col(2);
  if (manner.turn) {
    TurnBy(-by * kRollPerStep * AxisOfLock().value_or(towards_eye));
    return;
  }
  const double factor = std::max(std::pow(1 + kDepthPerStep, by), kNearestStep);
  const Vec3 from_eye = p_W_ - camera.eye_W();
  const Vec3 by_W = (factor - 1) * from_eye;
  const std::optional<Vec3> axis = AxisOfLock();
  if (!axis) {
    MoveBy(by_W);
  } else if (!lock_->plane) {
    // along the axis by the same length
    const double sign = axis->dot(from_eye) < 0 ? -1 : 1;
    MoveBy(((factor - 1) * sign * from_eye.norm()) * *axis);
  } else {
    MoveBy(by_W - by_W.dot(*axis) * *axis);
  }
}

void PartDrag::Nudge(const CameraModel& camera, const Vec3& by_C) {
  const Vec3 by_W = camera.R_WC() * by_C;
  const std::optional<Vec3> axis = AxisOfLock();
  if (!axis) {
    MoveBy(by_W);
  } else if (lock_->plane) {
    MoveBy(by_W - by_W.dot(*axis) * *axis);
  } else {
    const double sign = by_W.dot(*axis) < 0 ? -1 : 1;
    MoveBy((sign * by_C.norm()) * *axis);
  }
}

void PartDrag::NudgeTurn(const CameraModel& camera, const Vec3& by_C) {
  const Vec3 by_W = camera.R_WC() * by_C;
  const std::optional<Vec3> axis = AxisOfLock();
  if (!axis) {
    TurnBy(by_W);
    return;
  }
  const double sign = by_W.dot(*axis) < 0 ? -1 : 1;
  TurnBy((sign * by_C.norm()) * *axis);
}

void PartDrag::TurnAlong(const Vec2& along_px, double px_per_rad) {
  ring_px_ = along_px;
  px_per_rad_ = px_per_rad;
}

std::optional<AxisLock> NextLock(const std::optional<AxisLock>& now, int axis, bool plane) {
  if (!now || now->axis != axis || now->plane != plane) return AxisLock{axis, plane, false};
  if (!now->of_part) return AxisLock{axis, plane, true};
  return std::nullopt;
}

}  // namespace tandem
