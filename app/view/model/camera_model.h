#pragma once

#include <optional>

#include "engine/base/spatial.h"

namespace tandem {

using Vec2 = Eigen::Vector2d;
using Mat4 = Eigen::Matrix4d;

enum class StandardView { kFront, kRight, kTop, kIso };

/// A line of sight.
struct Ray {
  Vec3 from_W = Vec3::Zero();
  Vec3 along_W = Vec3::UnitX();  // a unit vector
};

/// Where the onlooker stands: a turntable about a target point, Z up, in perspective. Plain
/// mathematics, no window. Camera frame C: x to the right, y up, z towards the eye; pixels are
/// logical, from the top left.
class CameraModel {
 public:
  void SetViewport(int width_px, int height_px);
  /// Puts the whole box into the picture, seen from where the camera looks now.
  void Fit(const Bounds& bounds_W);
  void LookFrom(StandardView view);

  /// Turns the scene with the mouse, half a turn for 360 px; never over the poles.
  void Orbit(double dx_px, double dy_px);
  /// Moves the scene with the mouse: a point at the target's depth stays under the cursor.
  void Pan(double dx_px, double dy_px);
  /// Comes nearer (steps > 0) or goes away; what is under the cursor at the target's depth stays
  /// there.
  void ZoomAt(const Vec2& cursor_px, double steps);

  Mat4 ViewFromWorld() const;
  Mat4 Projection() const;
  /// Pixel of a point, or nothing when it is behind the eye.
  std::optional<Vec2> Project(const Vec3& p_W) const;
  /// Line of sight through a pixel, from the eye.
  Ray RayThrough(const Vec2& px) const;
  /// Length in metres of a pixel, across the view, at the depth of a point.
  double MetresPerPixelAt(const Vec3& p_W) const;
  /// Point under a pixel at the target's depth.
  Vec3 PointAtTargetDepth(const Vec2& px) const;

  /// Columns are the camera's right, up and towards-the-eye in W.
  Mat3 R_WC() const;
  /// Of the user's view V: to the right, away from the eye, up.
  Mat3 R_WV() const;
  Vec3 eye_W() const { return target_W_ + distance_ * R_WC().col(2); }
  const Vec3& target_W() const { return target_W_; }
  double distance() const { return distance_; }
  double elevation() const { return elevation_; }
  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

 private:
  double MetresPerPixel() const;  // at the target's depth

  Vec3 target_W_ = Vec3::Zero();
  double distance_ = 1.0;   // m, eye to target
  double azimuth_ = 0.0;    // rad about Z; 0 looks along +Y
  double elevation_ = 0.0;  // rad above the horizon
  Vec3 scene_centre_W_ = Vec3::Zero();
  double scene_radius_ = 0.5;  // m
  int width_px_ = 1;
  int height_px_ = 1;
};

}  // namespace tandem
