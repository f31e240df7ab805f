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
  Vec3 along_W = Vec3::UnitX();  // unit vector
};

/// The viewer's camera: a turntable about a target point, Z up, in perspective. It is mathematics
/// alone, without a window. Camera frame C: x to the right, y up, z towards the eye. Pixels are
/// logical, from the top left.
class CameraModel {
 public:
  void SetViewport(int width_px, int height_px);
  /// Fits the whole box into the picture and keeps the direction of view.
  void Fit(const Bounds& bounds_W);
  void LookFrom(StandardView view);

  /// Turns the scene with the mouse, half a turn for 360 px, but not over the poles.
  void Orbit(double dx_px, double dy_px);
  /// Moves the scene with the mouse: a point at the target's depth stays under the cursor.
  void Pan(double dx_px, double dy_px);
  /// Moves nearer (steps > 0) or away. The point under the cursor at the target's depth stays
  /// there.
  void ZoomAt(const Vec2& cursor_px, double steps);

  Mat4 ViewFromWorld() const;
  Mat4 Projection() const;
  /// Returns the pixel of a point; nothing: the point is behind the eye.
  std::optional<Vec2> Project(const Vec3& p_W) const;
  /// Returns the line of sight through a pixel, from the eye.
  Ray RayThrough(const Vec2& px) const;
  /// Returns the length of a pixel in metres, across the view, at the depth of a point.
  double MetresPerPixelAt(const Vec3& p_W) const;
  /// Returns the point under a pixel at the target's depth.
  Vec3 PointAtTargetDepth(const Vec2& px) const;

  /// Returns the camera's right, up and towards-the-eye in W, as columns.
  Mat3 R_WC() const;
  /// Returns the axes of the user's view V in W: to the right, away from the eye, up.
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
