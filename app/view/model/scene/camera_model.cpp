#include "app/view/model/scene/camera_model.h"

namespace tandem {

namespace {
constexpr double kPi = 3.14159265358979323846;
constexpr double kHalfFieldOfView =
    16.0 * kPi / 180.0;  // rad, vertical; narrow enough to keep shapes undistorted
constexpr double kFitMargin = 1.06;
constexpr double kZoomPerStep = 0.85;
constexpr double kNearestPart = 0.002;  // nearest distance to the target, share of the scene's
                                        // radius
constexpr double kFarthestPart = 200.0;
}  // namespace

void CameraModel::SetViewport(int width_px, int height_px) {
  width_px_ = std::max(width_px, 1);
  height_px_ = std::max(height_px, 1);
}

Mat3 CameraModel::R_WV() const {
  const Mat3 R = R_WC();
  Mat3 turned;
  turned << R.col(0), -R.col(2), R.col(1);
  return turned;
}

Mat3 CameraModel::R_WC() const {
  const Vec3 towards_eye(std::cos(elevation_) * std::sin(azimuth_),
                         -std::cos(elevation_) * std::cos(azimuth_), std::sin(elevation_));
  const Vec3 right(std::cos(azimuth_), std::sin(azimuth_), 0.0);
  Mat3 R;
  R.col(0) = right;
  R.col(1) = towards_eye.cross(right);
  R.col(2) = towards_eye;
  return R;
}

void CameraModel::Fit(const Bounds& bounds_W) {
  if (bounds_W.empty()) return;
  scene_centre_W_ = bounds_W.centre();
  scene_radius_ = std::max(0.5 * bounds_W.size().norm(), 1e-6);
  target_W_ = scene_centre_W_;

  // each corner needs a distance at which it lies between both pairs of sides of the view pyramid
  const double tan_y = std::tan(kHalfFieldOfView);
  const double tan_x = tan_y * width_px_ / height_px_;
  const Mat3 R_CW = R_WC().transpose();
  double distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p_W((corner & 1) != 0 ? bounds_W.max.x() : bounds_W.min.x(),
                   (corner & 2) != 0 ? bounds_W.max.y() : bounds_W.min.y(),
                   (corner & 4) != 0 ? bounds_W.max.z() : bounds_W.min.z());
    const Vec3 p_C = R_CW * (p_W - target_W_);
    distance = std::max(
        {distance, p_C.z() + std::abs(p_C.x()) / tan_x, p_C.z() + std::abs(p_C.y()) / tan_y});
  }
  distance_ = std::max(kFitMargin * distance, kNearestPart * scene_radius_);
}

void CameraModel::LookFrom(StandardView view) {
  switch (view) {
    case StandardView::kFront:
      azimuth_ = 0;
      elevation_ = 0;
      return;
    case StandardView::kRight:
      azimuth_ = kPi / 2;
      elevation_ = 0;
      return;
    case StandardView::kTop:
      azimuth_ = 0;
      elevation_ = kPi / 2;
      return;
    case StandardView::kIso:
      azimuth_ = kPi / 5;
      elevation_ = kPi / 6;
      return;
  }
}

void CameraModel::Orbit(double dx_px, double dy_px) {
  constexpr double kPerPixel = kPi / 360.0;
  azimuth_ = std::remainder(azimuth_ - kPerPixel * dx_px, 2 * kPi);
  elevation_ = std::clamp(elevation_ + kPerPixel * dy_px, -kPi / 2, kPi / 2);
}

double CameraModel::MetresPerPixel() const {
  return 2.0 * distance_ * std::tan(kHalfFieldOfView) / height_px_;
}

void CameraModel::Pan(double dx_px, double dy_px) {
  const Mat3 R = R_WC();
  target_W_ += MetresPerPixel() * (dy_px * R.col(1) - dx_px * R.col(0));
}

void CameraModel::ZoomAt(const Vec2& cursor_px, double steps) {
  const double wanted = distance_ * std::pow(kZoomPerStep, steps);
  const double distance =
      std::clamp(wanted, kNearestPart * scene_radius_, kFarthestPart * scene_radius_);
  const Vec3 under_cursor_W = PointAtTargetDepth(cursor_px);
  target_W_ += (1.0 - distance / distance_) * (under_cursor_W - target_W_);
  distance_ = distance;
}

Vec3 CameraModel::PointAtTargetDepth(const Vec2& px) const {
  const Mat3 R = R_WC();
  const double x = px.x() - 0.5 * width_px_;
  const double y = 0.5 * height_px_ - px.y();
  return target_W_ + MetresPerPixel() * (x * R.col(0) + y * R.col(1));
}

Ray CameraModel::RayThrough(const Vec2& px) const {
  const Vec3 eye = eye_W();
  return {eye, (PointAtTargetDepth(px) - eye).normalized()};
}

double CameraModel::MetresPerPixelAt(const Vec3& p_W) const {
  const double depth = (eye_W() - p_W).dot(R_WC().col(2));
  return 2.0 * std::max(depth, 0.0) * std::tan(kHalfFieldOfView) / height_px_;
}

Mat4 CameraModel::ViewFromWorld() const {
  const Mat3 R_CW = R_WC().transpose();
  Mat4 X = Mat4::Identity();
  X.topLeftCorner<3, 3>() = R_CW;
  X.topRightCorner<3, 1>() = -(R_CW * eye_W());
  return X;
}

Mat4 CameraModel::Projection() const {
  // bodies may leave the fitted box, so the planes lie well before and behind it
  const double to_scene = (eye_W() - scene_centre_W_).norm();
  const double near = std::max(0.01 * distance_, to_scene - 5 * scene_radius_);
  const double far = std::max(to_scene + 8 * scene_radius_, 2 * near);
  const double tan_y = std::tan(kHalfFieldOfView);
  Mat4 P = Mat4::Zero();
  P(0, 0) = height_px_ / (tan_y * width_px_);
  P(1, 1) = 1.0 / tan_y;
  P(2, 2) = -(far + near) / (far - near);
  P(2, 3) = -2 * far * near / (far - near);
  P(3, 2) = -1;
  return P;
}

std::optional<Vec2> CameraModel::Project(const Vec3& p_W) const {
  const Vec3 p_C = R_WC().transpose() * (p_W - eye_W());
  if (p_C.z() > -1e-9) return std::nullopt;
  const double px_per_tan = 0.5 * height_px_ / std::tan(kHalfFieldOfView);
  return Vec2(0.5 * width_px_ - px_per_tan * p_C.x() / p_C.z(),
              0.5 * height_px_ + px_per_tan * p_C.y() / p_C.z());
}

}  // namespace tandem
