#include "app/view/ui/hand_mouse.h"

#include <QKeyEvent>
#include <QMouseEvent>
#include <QWheelEvent>

namespace tandem {

namespace {

constexpr double kUnitsPerWheelNotch = 120;

Vec2 Pixel(const QPointF& at) {
  return {at.x(), at.y()};
}

DragManner MannerOf(Qt::KeyboardModifiers modifiers) {
  return {modifiers.testFlag(Qt::ControlModifier), modifiers.testFlag(Qt::ShiftModifier)};
}

}  // namespace

HandMouse::HandMouse(HandModel& hand, ViewWidget& view, QObject* parent)
    : QObject(parent), hand_(hand), view_(view) {
  view_.setMouseTracking(true);
  view_.installEventFilter(this);
}

bool HandMouse::eventFilter(QObject*, QEvent* event) {
  if (!hand_.ready()) return false;
  switch (event->type()) {
    case QEvent::MouseButtonPress: {
      const auto* press = static_cast<QMouseEvent*>(event);
      return press->button() == Qt::LeftButton && Press(press->position(), press->modifiers());
    }
    case QEvent::MouseMove: {
      const auto* move = static_cast<QMouseEvent*>(event);
      return Move(move->position(), move->modifiers(), move->buttons());
    }
    case QEvent::MouseButtonRelease:
      if (!dragging_ || static_cast<QMouseEvent*>(event)->button() != Qt::LeftButton) return false;
      EndDrag();
      return true;
    case QEvent::Wheel: {
      const auto* wheel = static_cast<QWheelEvent*>(event);
      // y alone: Qt swaps the wheel's axes only with Alt
      return Turn(wheel->angleDelta().y(), wheel->modifiers());
    }
    case QEvent::KeyPress: {
      const auto* key = static_cast<QKeyEvent*>(event);
      return Key(key->key(), key->modifiers());
    }
    default:
      return false;
  }
}

std::optional<PartHit> HandMouse::HitAt(const Vec2& px) const {
  if (view_.scene() == nullptr) return std::nullopt;
  std::optional<PartHit> hit =
      PickPart(view_.camera().RayThrough(px), *view_.scene(), view_.draw_list());
  if (!hit) return hit;
  const BodyLook& look = view_.scene()->bodies[hit->body].look;
  hit->body = look.part_of.value_or(hit->body);
  return hit;
}

std::optional<PartHit> HandMouse::UnderCursor() const {
  return HitAt(cursor_px_);
}

bool HandMouse::Press(const QPointF& at, Qt::KeyboardModifiers modifiers) {
  cursor_px_ = Pixel(at);
  view_.setFocus(Qt::MouseFocusReason);
  if (hand_.stopped() || hand_.by_device()) return false;
  if (BeginByTriad(cursor_px_)) return true;
  const std::optional<PartHit> hit = HitAt(cursor_px_);
  if (!hit || view_.scene()->bodies[hit->body].look.fixed) return false;
  if (modifiers.testFlag(Qt::AltModifier)) return false;  // Alt moves the camera, over a body too
  if (hand_.held() == hit->body) {
    drag_.Begin(cursor_px_, hit->p_W, hand_.goal());
  } else {
    drag_.Lock(std::nullopt);
    drag_.Begin(cursor_px_, hit->p_W, Pose{Quat::Identity(), hit->p_W});
    hand_.Grab(hit->body, hit->p_W);
  }
  by_handle_ = false;
  dragging_ = true;
  Q_EMIT Changed();
  return true;
}

bool HandMouse::BeginByTriad(const Vec2& px) {
  if (!triad_ || !hand_.held()) return false;
  const std::optional<TriadPicture> picture = DrawTriad(view_.camera(), TriadPose());
  const auto handle = picture ? PickTriad(*picture, px) : std::nullopt;
  if (!handle) return false;
  lock_before_ = drag_.lock();
  const bool of_part = lock_before_ && lock_before_->of_part;
  handle_manner_ =
      BeginByHandle(view_.camera(), TriadPose(), *handle, of_part, px, hand_.goal(), drag_);
  by_handle_ = true;
  dragging_ = true;
  hot_ = handle;
  Q_EMIT Changed();
  return true;
}

bool HandMouse::Move(const QPointF& at, Qt::KeyboardModifiers modifiers, Qt::MouseButtons buttons) {
  cursor_px_ = Pixel(at);
  if (!dragging_) {
    std::optional<TriadHandle> hot;
    if (triad_ && hand_.held() && buttons == Qt::NoButton) {
      const std::optional<TriadPicture> picture = DrawTriad(view_.camera(), TriadPose());
      if (picture) hot = PickTriad(*picture, cursor_px_);
    }
    if (hot != hot_) {
      hot_ = hot;
      Q_EMIT Changed();
    }
    return false;
  }
  if (!buttons.testFlag(Qt::LeftButton)) {  // another window got the button's release
    EndDrag();
    return false;
  }
  DragManner manner = MannerOf(modifiers);
  if (by_handle_) manner.turn = handle_manner_.turn;
  drag_.Follow(view_.camera(), cursor_px_, manner);
  HandOn();
  return true;
}

bool HandMouse::Turn(int notches, Qt::KeyboardModifiers modifiers) {
  if (!dragging_) return false;
  drag_.Wheel(view_.camera(), notches / kUnitsPerWheelNotch, MannerOf(modifiers));
  HandOn();
  return true;
}

bool HandMouse::Key(int key, Qt::KeyboardModifiers modifiers) {
  const std::optional<HandKey> pressed = HandKeyOf(key, modifiers);
  if (!pressed || !hand_.held() || hand_.by_device() || view_.scene() == nullptr) return false;
  if (!dragging_) BeginAtGoal();
  if (pressed->kind == HandKey::Kind::kLock) {
    drag_.Lock(NextLock(drag_.lock(), pressed->axis, pressed->plane));
    Q_EMIT Changed();
    return true;
  }
  if (pressed->kind == HandKey::Kind::kTurn) {
    drag_.NudgeTurn(view_.camera(), kNudgeTurn * pressed->steps_C);
  } else {
    drag_.Nudge(view_.camera(), kNudgeVoxels * view_.scene()->voxel_size * pressed->steps_C);
  }
  HandOn();
  return true;
}

void HandMouse::BeginAtGoal() {
  const Pose goal = hand_.goal();
  drag_.Begin(cursor_px_, goal.p, goal);
}

void HandMouse::HandOn() {
  hand_.SetGoal(drag_.goal());
  Q_EMIT Changed();
}

void HandMouse::EndDrag() {
  if (dragging_ && by_handle_) drag_.Lock(lock_before_);
  dragging_ = false;
  by_handle_ = false;
  hot_.reset();
  Q_EMIT Changed();
}

void HandMouse::ShowTriad(bool shown) {
  triad_ = shown;
  hot_.reset();
  Q_EMIT Changed();
}

Pose HandMouse::TriadPose() const {
  // at the part's pose rather than the goal's: the user takes hold of what is visible
  Pose X_WT = ToPose(hand_.snapshot().hand.X_WG);
  const bool of_part = drag_.lock() && drag_.lock()->of_part;
  if (!of_part) X_WT.q = Quat::Identity();
  return X_WT;
}

HandPicture HandMouse::Dressed(HandPicture picture) const {
  if (!hand_.held()) return picture;
  if (triad_) picture.X_WT = TriadPose();
  picture.hot = hot_;
  const std::optional<Vec3> axis = drag_.AxisOfLock();
  if (axis) picture.locked_line_W = {hand_.goal().p, *axis};
  return picture;
}

}  // namespace tandem
