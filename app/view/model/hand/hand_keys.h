#pragma once

#include <Qt>
#include <optional>

#include "engine/base/spatial.h"

namespace tandem {

/// The action of a key on the part in hand.
struct HandKey {
  enum class Kind { kNudge, kTurn, kLock };
  Kind kind = Kind::kNudge;
  /// Nudge and turn: steps along, or about, the picture's right, up and towards-the-eye axes.
  Vec3 steps_C = Vec3::Zero();
  int axis = 0;        // axis of a lock
  bool plane = false;  // true: the lock is to the plane normal to that axis
};

/// Returns a key's action. Arrows move the part in the picture's plane, Page Up away from the eye,
/// Page Down towards it. With Ctrl they turn it; with Shift the step is a tenth. X, Y and Z lock to
/// an axis, with Shift to the plane normal to it. Nothing: the key has no action.
std::optional<HandKey> HandKeyOf(int key, Qt::KeyboardModifiers modifiers);

inline constexpr double kNudgeVoxels = 1;  // length of a step
inline constexpr double kNudgeTurn = 3.14159265358979323846 / 180;

}  // namespace tandem
