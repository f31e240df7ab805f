#pragma once

#include <algorithm>
#include <cmath>

#include "engine/contact/pair/contact_kind.h"

namespace tandem {

/// The rate at which a clearance changes, m/s. It pushes a hand in contact away, or lets it in, at
/// this pace.
inline constexpr double kClearancePace = 0.01;

/// The distance from surfaces at which contact begins, as far as it can be changed while running
/// (paper §3.2).
struct Clearance {
  double layers = 0;  // thickness of the force layer; fractional while it changes
  /// Shift of the points along their inward normals, m; positive: less clearance.
  double displacement = 0;
  bool operator==(const Clearance&) const = default;
};

/// The bounds of a clearance.
struct ClearanceBounds {
  int least_layer = 0;
  int most_layer = 0;
  double most_inward = 0;   // greatest displacement inward, m
  double most_outward = 0;  // greatest displacement outward, m

  /// Gives the bounds of plain contact, whose marks reach `range` voxels. Displacement tunes
  /// between one layer and the next.
  static constexpr ClearanceBounds ForMarks(int range, double voxel_size) {
    const int most = std::max(0, range - kWarningQueues);
    return {std::min(LeastForceLayer(ContactModel::kPlain), most), most, voxel_size, voxel_size};
  }
  /// Gives the bounds of refined contact, whose distance fields reach `farther` voxels beyond where
  /// force begins.
  static constexpr ClearanceBounds ForFields(double farther, double voxel_size) {
    const int least = LeastForceLayer(ContactModel::kRefined);
    return {least, least + std::max(0, static_cast<int>(farther)), voxel_size,
            std::max(0.0, farther) * voxel_size};
  }
  bool Allows(double displacement) const noexcept {
    return displacement >= -most_outward && displacement <= most_inward;
  }
  /// Returns the nearest clearance within the bounds; a displacement that is not finite becomes 0.
  Clearance Clamp(int layer, double displacement) const noexcept {
    const double metres = std::isfinite(displacement) ? displacement : 0.0;
    return {static_cast<double>(std::clamp(layer, least_layer, most_layer)),
            std::clamp(metres, -most_outward, most_inward)};
  }
};

/// Returns the clearance after `seconds` on the way from one to another. Where both parts change
/// they share the pace.
inline Clearance StepClearance(const Clearance& from, const Clearance& to, double seconds,
                               double voxel_size) noexcept {
  const auto go = [](double at, double goal, double step) {
    return std::abs(goal - at) <= step ? goal : at + std::copysign(step, goal - at);
  };
  const bool both = from.layers != to.layers && from.displacement != to.displacement;
  const double step = (both ? 0.5 : 1.0) * kClearancePace * seconds;
  return {go(from.layers, to.layers, step / voxel_size),
          go(from.displacement, to.displacement, step)};
}

}  // namespace tandem
