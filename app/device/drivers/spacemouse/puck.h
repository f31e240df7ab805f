#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/spatial.h"

namespace tandem::driver {

/// How the puck's six numbers move the hand.
struct PuckSettings {
  static constexpr double kFullScale = 350;  // full scale of an axis, as the daemon reports it

  double speed = 0.1;         // m/s at full scale
  double turn = 1.0;          // rad/s
  double dead_zone = 0.03;    // share of the full scale that counts as zero
  bool moves_camera = false;  // true: the view seems to move, so the part moves the opposite way
  bool dominant = false;      // true: only the strongest of the six axes moves the part
};

/// The user's rates in V.
struct PuckRates {
  Vec3 v = Vec3::Zero();  // m/s
  Vec3 w = Vec3::Zero();  // rad/s
};

/// Converts the daemon's numbers x y z rx ry rz to rates in V. The daemon's axes are x right, y up,
/// z away from the person. `dominant`: the axis that moved the hand last, where only the strongest
/// does; another axis takes over when it is clearly stronger.
PuckRates RatesOf(const std::array<std::int32_t, 6>& axes, const PuckSettings& settings,
                  std::size_t& dominant) noexcept;

}  // namespace tandem::driver
