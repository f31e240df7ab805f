#pragma once

#include <optional>

#include "app/view/model/camera_model.h"

namespace tandem {

/// What limits a drag to one axis, or to the plane across it.
struct AxisLock {
  int axis = 0;          // 0 x, 1 y, 2 z
  bool plane = false;    // the motion keeps to the plane across the axis
  bool of_part = false;  // the axis turns with the part; else it is the world's
  bool operator==(const AxisLock&) const = default;
};

/// What a motion of the mouse means.
struct DragManner {
  bool turn = false;  // about the grabbed point; else the part moves
  bool fine = false;  // at a tenth of the speed
};

/// Turns mouse and keys into a goal for a part in the hand: plain mathematics, without a window and
/// without physics. The goal is a pose `X_WG` of any frame G that is fixed to the part; a drag
/// changes it by motions of the world's frame, so that the choice of G is the caller's.
///
/// A motion of the mouse moves the grabbed point in the plane through it and parallel to the
/// picture. At full speed the grabbed point stays under the cursor, so a goal that ran into
/// something is back at the part when the cursor is.
class PartDrag {
 public:
  static constexpr double kFine = 0.1;  // of the speed
  static constexpr double kTurnPerPixel = 0.5 * 3.14159265358979323846 / 180;
  static constexpr double kDepthPerStep = 0.02;  // of the distance to the eye
  static constexpr double kRollPerStep = 5 * 3.14159265358979323846 / 180;

  /// Takes hold at `p_W` with the cursor there. `X_WG` is the goal from which the drag goes on.
  void Begin(const Vec2& cursor_px, const Vec3& p_W, const Pose& X_WG);
  /// Goes on from another goal, which somebody else has moved meanwhile; the grabbed point goes
  /// with it.
  void GoOnFrom(const Pose& X_WG);

  /// The mouse is at `cursor_px` now.
  void Follow(const CameraModel& camera, const Vec2& cursor_px, const DragManner& manner);
  /// A notch of the wheel (steps > 0: away from the eye): depth along the line of sight; with
  /// `turn` a roll about the line of sight.
  void Wheel(const CameraModel& camera, double steps, const DragManner& manner);
  /// Moves by metres along the camera's right, up and towards the eye; along the lock's axis where
  /// there is one.
  void Nudge(const CameraModel& camera, const Vec3& by_C);
  /// Turns by angles about the same axes.
  void NudgeTurn(const CameraModel& camera, const Vec3& by_C);

  /// From now on; nothing: free. A turn is about the lock's axis.
  void Lock(const std::optional<AxisLock>& lock) { lock_ = lock; }
  /// Has the next turn follow `along_px` in the picture, by `px_per_rad` along it: the way in which
  /// a ring's grabbed point moves.
  void TurnAlong(const Vec2& along_px, double px_per_rad);
  const std::optional<AxisLock>& lock() const { return lock_; }
  /// Unit vector of the lock's axis in W; nothing without a lock.
  std::optional<Vec3> AxisOfLock() const;

  const Pose& goal() const { return X_WG_; }
  /// Where the grabbed point is to be.
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
  Vec2 ring_px_ = Vec2::Zero();  // unit; zero: no ring
  double px_per_rad_ = 0;
};

/// The lock after a key of an axis: none, the world's axis, the part's own, none again. A key of
/// another axis begins anew.
std::optional<AxisLock> NextLock(const std::optional<AxisLock>& now, int axis, bool plane);

}  // namespace tandem
