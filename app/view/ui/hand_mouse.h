#pragma once

#include <QObject>
#include <QPointF>
#include <optional>

#include "app/view/model/hand/hand_keys.h"
#include "app/view/model/hand/hand_model.h"
#include "app/view/model/hand/part_drag.h"
#include "app/view/model/hand/part_picking.h"
#include "app/view/ui/view_widget.h"

namespace tandem {

/// Handles the mouse and keys that take and move parts. It filters the events of the ViewWidget,
/// which uses the others for the camera.
///
/// The left button on a moving body takes it in hand and drags it. With Ctrl the body turns, with
/// Shift it moves a tenth as far, and the wheel meanwhile moves it in depth. Releasing the button
/// leaves the part in hand, with its goal where it is.
class HandMouse : public QObject {
  Q_OBJECT

 public:
  HandMouse(HandModel& hand, ViewWidget& view, QObject* parent = nullptr);

  /// Adds the mouse's part to the hand's picture.
  HandPicture Dressed(HandPicture picture) const;
  void ShowTriad(bool shown);
  bool shows_triad() const { return triad_; }
  /// Returns the body under the cursor, or nothing. A merged body counts as the body it belongs to.
  std::optional<PartHit> UnderCursor() const;
  /// Ends the drag: the mouse moves nothing until its button is pressed again.
  void EndDrag();
  bool dragging() const { return dragging_; }
  const std::optional<AxisLock>& lock() const { return drag_.lock(); }

 Q_SIGNALS:
  /// The goal, the lock or the handle under the cursor has changed.
  void Changed();
  /// A fixed body was pressed, which cannot be taken.
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
  std::optional<AxisLock> lock_before_;  // lock to restore after a handle's drag
  bool triad_ = false;
  std::optional<TriadHandle> hot_;
  Vec2 cursor_px_ = Vec2::Zero();
};

}  // namespace tandem
