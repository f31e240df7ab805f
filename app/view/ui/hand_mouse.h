#pragma once

#include <QObject>
#include <QPointF>
#include <optional>

#include "app/view/model/hand_keys.h"
#include "app/view/model/hand_model.h"
#include "app/view/model/part_drag.h"
#include "app/view/model/part_picking.h"
#include "app/view/ui/view_widget.h"

namespace tandem {

/// Mouse and keys of the picture, as far as they take and move parts: stands before the ViewWidget,
/// which gets what is left over for the camera.
///
/// The left button on a body that moves takes it in hand and drags it; with Ctrl it turns, with
/// Shift it goes a tenth as far; the wheel meanwhile is depth. The button's release leaves the part
/// in hand, with its goal where it is.
class HandMouse : public QObject {
  Q_OBJECT

 public:
  HandMouse(HandModel& hand, ViewWidget& view, QObject* parent = nullptr);

  /// The hand's picture with what the mouse adds to it.
  HandPicture Dressed(HandPicture picture) const;
  void ShowTriad(bool shown);
  bool shows_triad() const { return triad_; }
  /// The body under the cursor, or nothing; merged bodies count as the one they belong to.
  std::optional<PartHit> UnderCursor() const;
  /// Ends the drag: the mouse has no say until its button is pressed again.
  void EndDrag();
  bool dragging() const { return dragging_; }
  const std::optional<AxisLock>& lock() const { return drag_.lock(); }

 Q_SIGNALS:
  /// The goal, the lock or the handle under the cursor is another one.
  void Changed();
  /// A fixed body was pressed, which nobody can take.
  void FixedPressed(const QString& body);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  bool Press(const QPointF& at, Qt::KeyboardModifiers modifiers);
  bool Move(const QPointF& at, Qt::KeyboardModifiers modifiers, Qt::MouseButtons buttons);
  bool Turn(int notches, Qt::KeyboardModifiers modifiers);
  bool Key(int key, Qt::KeyboardModifiers modifiers);
  bool BeginByTriad(const Vec2& px);
  void BeginAtGoal();
  void HandOn();
  Pose TriadPose() const;
  std::optional<PartHit> HitAt(const Vec2& px) const;

  HandModel& hand_;
  ViewWidget& view_;
  PartDrag drag_;
  bool dragging_ = false;
  bool by_handle_ = false;
  DragManner handle_manner_;
  std::optional<AxisLock> lock_before_;  // in force again after a handle's drag
  bool triad_ = false;
  std::optional<TriadHandle> hot_;
  Vec2 cursor_px_ = Vec2::Zero();
};

}  // namespace tandem
