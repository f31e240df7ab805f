#pragma once

#include <algorithm>
#include <cmath>

#include "engine/contact/contact_kind.h"

namespace tandem {

/// How fast a clearance goes to another one, m/s: a hand in contact is pushed away or let in at
/// this pace.
inline constexpr double kClearancePace = 0.01;

/// How far from surfaces contact begins, as far as it may be changed while running (paper §3.2).
struct Clearance {
  double layers = 0;        // the force layer; between whole ones while it goes to another
  double displacement = 0;  // m, of the points along their inward normals: less clearance
  bool operator==(const Clearance&) const = default;
};

/// What a clearance may be.
struct ClearanceBounds {
  int least_layer = 0;
  int most_layer = 0;
  double most_inward = 0;   // m, of a displacement
  double most_outward = 0;  // m, of one the other way

  /// Gives the bounds of plain contact, whose marks reach `range` voxels. Displacement tunes
  /// between one layer and the next.
  static constexpr ClearanceBounds OfMarks(int range, double voxel_size) {
    const int most = std::max(0, range - kWarningQueues);
    return {std::min(LeastForceLayer(ContactModel::kPlain), most), most, voxel_size, voxel_size};
  }
  /// Gives those of refined contact, whose distance fields reach `farther` voxels beyond where
  /// force begins.
  static constexpr ClearanceBounds OfFields(double farther, double voxel_size) {
    const int least = LeastForceLayer(ContactModel::kRefined);
    return {least, least + std::max(0, static_cast<int>(farther)), voxel_size,
            std::max(0.0, farther) * voxel_size};
  }
  bool Allows(double displacement) const noexcept {
    return displacement >= -most_outward && displacement <= most_inward;
  }
  /// The nearest that is allowed; what is no number is no displacement.
  Clearance Within(int layer, double displacement) const noexcept {
    const double metres = std::isfinite(displacement) ? displacement : 0.0;
    return {static_cast<double>(std::clamp(layer, least_layer, most_layer)),
            std::clamp(metres, -most_outward, most_inward)};
  }
};

/// One clearance on its way to another, after `seconds`. Where both parts change they share the
/// pace.
inline Clearance Nearer(const Clearance& from, const Clearance& to, double seconds,
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
