#include "app/view/model/hand/hand_keys.h"

#include "app/view/model/hand/part_drag.h"

namespace tandem {

namespace {

/// Returns the step of an arrow or page key in the picture, or zero.
Vec3 StepOf(int key) {
  switch (key) {
    case Qt::Key_Left:
      return -Vec3::UnitX();
    case Qt::Key_Right:
      return Vec3::UnitX();
    case Qt::Key_Down:
      return -Vec3::UnitY();
    case Qt::Key_Up:
      return Vec3::UnitY();
    case Qt::Key_PageUp:
      return -Vec3::UnitZ();
    case Qt::Key_PageDown:
      return Vec3::UnitZ();
    default:
      return Vec3::Zero();
  }
}

}  // namespace

std::optional<HandKey> HandKeyOf(int key, Qt::KeyboardModifiers modifiers) {
  const bool shift = modifiers.testFlag(Qt::ShiftModifier);
  const bool control = modifiers.testFlag(Qt::ControlModifier);
  if (modifiers.testFlag(Qt::AltModifier)) return std::nullopt;
  HandKey found;
  if (key >= Qt::Key_X && key <= Qt::Key_Z && !control) {
    found.kind = HandKey::Kind::kLock;
    found.axis = key - Qt::Key_X;
    found.plane = shift;
    return found;
  }
  const Vec3 step = StepOf(key);
  if (step.isZero()) return std::nullopt;
  found.steps_C = (shift ? PartDrag::kFine : 1.0) * step;
  if (!control) return found;
  found.kind = HandKey::Kind::kTurn;
  // the near side moves as the arrow points: right and left turn about the picture's up
  const Vec3 s = found.steps_C;
  found.steps_C = Vec3(-s.y(), s.x(), s.z());
  return found;
}

}  // namespace tandem
