#pragma once

#include <array>
#include <optional>
#include <vector>

#include "app/view/model/hand/part_drag.h"
#include "app/view/model/scene/camera_model.h"

namespace tandem {

/// A handle of the triad: an arrow moves along an axis, a square moves in the plane normal to it, a
/// ring turns about it.
struct TriadHandle {
  enum class Kind { kArrow, kSquare, kRing };
  Kind kind = Kind::kArrow;
  int axis = 0;  // 0 x, 1 y, 2 z
  bool operator==(const TriadHandle&) const = default;
};

/// The handles in the picture, in logical pixels. Their size does not depend on the distance.
struct TriadPicture {
  static constexpr double kArrowPx = 80;
  static constexpr double kRingPx = 58;
  static constexpr double kSquareFrom = 0.30;  // share of an arrow's length
  static constexpr double kSquareTo = 0.52;
  static constexpr int kRingPoints = 48;

  struct Arrow {
    Vec2 from, to;
    bool usable = true;  // false: nearly a dot
  };
  std::array<Arrow, 3> arrows;
  std::array<std::array<Vec2, 4>, 3> squares;  // by the axis normal to them
  std::array<std::vector<Vec2>, 3> rings;      // closed, or the half that faces the eye
  std::array<bool, 3> square_usable{true, true, true};
  Vec2 origin = Vec2::Zero();
  double metres_per_px = 0;
};

/// Draws the triad at `X_WT`, along the axes of T. Nothing: it is behind the eye.
std::optional<TriadPicture> DrawTriad(const CameraModel& camera, const Pose& X_WT);

/// Returns the handle under or near a pixel: squares first, then arrows, then rings.
std::optional<TriadHandle> PickTriad(const TriadPicture& picture, const Vec2& px);

/// Begins a drag by a handle about the triad's origin, with the handle's lock. Returns the manner
/// of the mouse's motion.
DragManner BeginByHandle(const CameraModel& camera, const Pose& X_WT, const TriadHandle& handle,
                         bool axes_of_part, const Vec2& px, const Pose& X_WG, PartDrag& drag);

}  // namespace tandem
