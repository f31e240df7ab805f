#pragma once

#include <optional>

#include "app/view/model/scene/camera_model.h"

namespace tandem {

/// A limit of a drag to one axis, or to the plane normal to it.
struct AxisLock {
  int axis = 0;          // 0 x, 1 y, 2 z
  bool plane = false;    // true: the motion keeps to the plane normal to the axis
  bool of_part = false;  // true: the axis turns with the part; false: it is W's
  bool operator==(const AxisLock&) const = default;
};

/// The meaning of a mouse motion.
struct DragManner {
  bool turn = false;  // true: the part turns about the grabbed point; false: it moves
  bool fine = false;  // true: the speed is a tenth
};

/// Turns mouse and keys into a goal for a part in the hand: mathematics alone, without a window or
/// physics. The goal is a pose `X_WG` of any frame G fixed to the part. A drag changes it by
/// motions in W, so the caller chooses G.
///
/// A mouse motion moves the grabbed point in the plane through it that is parallel to the picture.
/// At full speed the grabbed point stays under the cursor. So a goal that went into an obstacle is
/// back at the part when the cursor is.
class PartDrag {
 public:
  static constexpr double kFine = 0.1;  // factor on the speed
  static constexpr double kTurnPerPixel = 0.5 * 3.14159265358979323846 / 180;
  static constexpr double kDepthPerStep = 0.02;  // share of the distance to the eye
  static constexpr double kRollPerStep = 5 * 3.14159265358979323846 / 180;

  /// Takes hold at `p_W`, which is under the cursor. `X_WG` is the goal from which the drag goes
  /// on.
  void Begin(const Vec2& cursor_px, const Vec3& p_W, const Pose& X_WG);
  /// Goes on from another goal that was set meanwhile; the grabbed point moves with it.
  void GoOnFrom(const Pose& X_WG);

  /// Moves the part by the cursor's motion to `cursor_px`.
  void Follow(const CameraModel& camera, const Vec2& cursor_px, const DragManner& manner);
  /// Moves the part by notches of the wheel (steps > 0: away from the eye) along the line of sight;
  /// with `turn` rolls it about that line.
  void Wheel(const CameraModel& camera, double steps, const DragManner& manner);
  /// Moves by metres along the camera's right, up and towards-the-eye axes; along the lock's axis
  /// where there is a lock.
  void Nudge(const CameraModel& camera, const Vec3& by_C);
  /// Turns by angles about the same axes.
  void NudgeTurn(const CameraModel& camera, const Vec3& by_C);

  /// Limits later motions to the lock; nothing: none. Turns are about the lock's axis.
  void Lock(const std::optional<AxisLock>& lock) { lock_ = lock; }
  /// Makes the next turn follow `along_px` in the picture, with `px_per_rad` along it. So a ring's
  /// grabbed point moves along the ring.
  void TurnAlong(const Vec2& along_px, double px_per_rad);
  const std::optional<AxisLock>& lock() const { return lock_; }
  /// Returns the lock's axis in W, a unit vector; nothing: no lock.
  std::optional<Vec3> AxisOfLock() const;

  const Pose& goal() const { return X_WG_; }
  /// Returns the goal of the grabbed point.
  const Vec3& point_W() const { return p_W_; }

 private:
  void MoveBy(const Vec3& by_W);
  void TurnBy(const Vec3& by_W);
  Vec3 MotionUnderCursor(const CameraModel& camera, const Vec2& from_px, const Vec2& to_px) const;
  Vec3 TurnUnderCursor(const CameraModel& camera, const Vec2& by_px) const;

  Pose X_WG_;
  Vec3 p_W_ = Vec3::Zero();
  Vec2 cursor_px_ = Vec2::Zero();
  std::optional<AxisLock> lock_;
  Vec2 ring_px_ = Vec2::Zero();  // unit vector; zero: no ring
  double px_per_rad_ = 0;
};

/// Returns the next lock for a key of an axis. One key cycles through no lock, the world's axis and
/// the part's own axis. A key of another axis starts again.
std::optional<AxisLock> NextLock(const std::optional<AxisLock>& now, int axis, bool plane);

}  // namespace tandem
