#pragma once

#include <Qt>
#include <optional>

#include "engine/base/spatial.h"

namespace tandem {

/// What a key does to the part in hand.
struct HandKey {
  enum class Kind { kNudge, kTurn, kLock };
  Kind kind = Kind::kNudge;
  /// Nudge and turn: steps along, or about, the picture's right, its up and towards the eye.
  Vec3 steps_C = Vec3::Zero();
  int axis = 0;        // of a lock
  bool plane = false;  // a lock to the plane across that axis
};

/// Arrows move in the picture's plane, Page Up away from the eye and Page Down towards it; with
/// Ctrl they turn instead, and with Shift by a tenth of a step. X, Y and Z lock to an axis, with
/// Shift to the plane across it. Nothing: the key is none of the hand's.
std::optional<HandKey> HandKeyOf(int key, Qt::KeyboardModifiers modifiers);

inline constexpr double kNudgeVoxels = 1;  // a step
inline constexpr double kNudgeTurn = 3.14159265358979323846 / 180;

}  // namespace tandem
