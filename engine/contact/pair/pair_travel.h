#pragma once

#include <algorithm>
#include <limits>

#include "engine/base/spatial.h"

namespace tandem {

/// Bounds how much nearer surface points of two bodies can have come from frame to frame.
class PairTravel {
 public:
  /// Returns the bound since the last call, m; infinity at the first call. The shell's points lie
  /// at most `shell_radius` from its frame's origin. What they may meet lies at most `map_radius`
  /// from the frame's origin of the map's body, in which the map's frame V stands at X_BV.
  double BoundApproach(const Pose& shell_WB, double shell_radius, const Pose& map_WB,
                       double map_radius, const Pose& X_BV) noexcept {
    double travel = std::numeric_limits<double>::infinity();
    if (placed_) {
      const auto of = [](const Pose& from, const Pose& to, double radius) {
        return TravelOf(to.p - from.p, RotationVector(to.q * from.q.conjugate()).norm(), radius);
      };
      travel = of(shell_WB_, shell_WB, shell_radius) + of(map_WB_, map_WB, map_radius);
      // bodies that move together come no nearer: seen from V the shell's points go no farther
      const auto seen = [&X_BV](const Pose& shell, const Pose& map) {
        return (map * X_BV).Inverse() * shell;
      };
      travel = std::min(travel, of(seen(shell_WB_, map_WB_), seen(shell_WB, map_WB), shell_radius));
    }
    placed_ = true;
    shell_WB_ = shell_WB;
    map_WB_ = map_WB;
    return travel;
  }

 private:
  Pose shell_WB_;
  Pose map_WB_;
  bool placed_ = false;
};

}  // namespace tandem
