#pragma once

#include <array>
#include <optional>
#include <vector>

#include "app/view/model/camera_model.h"
#include "app/view/model/part_drag.h"

namespace tandem {

/// A handle of the triad: an arrow moves along an axis, a square in the plane across it, a ring
/// turns about it.
struct TriadHandle {
  enum class Kind { kArrow, kSquare, kRing };
  Kind kind = Kind::kArrow;
  int axis = 0;  // 0 x, 1 y, 2 z
  bool operator==(const TriadHandle&) const = default;
};

/// Where the handles are in the picture, in logical pixels. All have the same size in the picture,
/// however far the part is.
struct TriadPicture {
  static constexpr double kArrowPx = 80;
  static constexpr double kRingPx = 58;
  static constexpr double kSquareFrom = 0.30;  // of an arrow's length
  static constexpr double kSquareTo = 0.52;
  static constexpr int kRingPoints = 48;

  struct Arrow {
    Vec2 from, to;
    bool usable = true;  // not nearly a dot
  };
  std::array<Arrow, 3> arrows;
  std::array<std::array<Vec2, 4>, 3> squares;  // by the axis across them
  std::array<std::vector<Vec2>, 3> rings;      // closed; only the half that faces the eye
  std::array<bool, 3> square_usable{true, true, true};
  Vec2 origin = Vec2::Zero();
  double metres_per_px = 0;
};

/// The triad at `X_WT` (its axes are T's). Nothing: it is behind the eye.
std::optional<TriadPicture> DrawTriad(const CameraModel& camera, const Pose& X_WT);

/// The handle under a pixel, if there is one within reach of it: squares before arrows before
/// rings.
std::optional<TriadHandle> PickTriad(const TriadPicture& picture, const Vec2& px);

/// Begins a drag by a handle: about the triad's origin, with the lock that the handle stands for.
/// Returns how the mouse is to be read.
DragManner BeginByHandle(const CameraModel& camera, const Pose& X_WT, const TriadHandle& handle,
                         bool axes_of_part, const Vec2& px, const Pose& X_WG, PartDrag& drag);

}  // namespace tandem
