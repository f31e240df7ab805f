#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/spatial.h"

namespace tandem::driver {

/// How the user wants the puck's six numbers to move the hand.
struct PuckSettings {
  static constexpr double kFullScale = 350;  // of an axis, as the daemon tells it

  double speed = 0.1;         // m/s at full scale
  double turn = 1.0;          // rad/s
  double dead_zone = 0.03;    // share of the full scale that counts as nothing
  bool moves_camera = false;  // the view seems to move: the part goes the other way
  bool dominant = false;      // only the strongest of the six moves it
};

/// The user's rates in V.
struct PuckRates {
  Vec3 v = Vec3::Zero();  // m/s
  Vec3 w = Vec3::Zero();  // rad/s
};

/// What the daemon's numbers x y z rx ry rz mean. Its axes are x right, y up, z away from the
/// person.
/// `dominant`: the axis that moved the hand alone last, where only the strongest does; another one
/// takes over when it is clearly stronger.
PuckRates RatesOf(const std::array<std::int32_t, 6>& axes, const PuckSettings& settings,
                  std::size_t& dominant) noexcept;

}  // namespace tandem::driver
