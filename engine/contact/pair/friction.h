#pragma once

#include <algorithm>

namespace tandem {

/// Slip below which a contact creeps instead of sticking, m/s. Friction is a damper there, which
/// reaches mu N at this speed.
inline constexpr double kCreepSpeed = 1e-4;

/// The largest coefficient mu that a file or another peer may ask for. No pair of materials has a
/// tenth of it; far above it the damping leaves the range of a double.
inline constexpr double kMostFriction = 100;

/// Coulomb friction of one contact, as a damper along the tangent that is as hard as the slip
/// `speed` (m/s) at the frame's start lets it be: mu N over the speed, N s/m. Stepped implicitly it
/// never turns a slip round, and it only ever takes energy.
inline double FrictionDamping(double friction, double normal_force, double speed) noexcept {
  return friction * normal_force / std::max(speed, kCreepSpeed);
}

}  // namespace tandem
