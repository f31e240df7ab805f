#pragma once

#include <algorithm>
#include <cmath>

namespace tandem {

inline constexpr double kFadeTime = 0.2;    // s, of a partner that is gone, at the least
inline constexpr double kGentleFall = 8.0;  // N/s that gentle falls may take from the links' forces
inline constexpr double kCappedFall = 10.0;    // N/s, where users are told of it
inline constexpr double kRisePower = 0.02;     // W that rises may put into the links' springs
inline constexpr double kFastestFall = 800.0;  // N/s that any fall may

/// Drag after h seconds in which it goes to `to`: up at once, down gently. The delay that gains are
/// made for falls at once when its peak is two seconds old; more drag than is needed is safe
/// meanwhile.
inline double DragAfter(double h, double from, double to) noexcept {
  constexpr double kMostDragFall = 100.0;  // N s/m in a second, of any drag
  return std::max(to, from - h * kMostDragFall);
}

/// How the stiffness of a link may change in a frame of h seconds.
struct StiffnessSlew {
  double h = 1e-3;         // s
  double stretch = 0;      // m, of the spring: sqrt(|d|^2 + theta^T (I/m) theta)
  double ceiling = 0;      // N/m that the delay allows: above, it falls in 20 ms, or a little later
  double wanted = 0;       // N/m to go to; at most the ceiling
  double room = 0;         // N/m that it may rise to, as the other links leave it
  double gentlest = 1e30;  // N/m/s: a gentle fall is not faster than this
  double gentle_fall = kGentleFall;  // N/s that such a fall may take
  double rise_power = kRisePower;    // W that a rise may put into the spring
  double energy = 1e30;              // J that a rise may put into the spring now

  /// A rise puts dk stretch^2/2 into the spring, which is bounded. A fall takes energy out, so it
  /// may be as fast as the delay wants; where its cause is only that nobody answers, or that one
  /// more has come, it is gentle: a held copy is a fixed anchor and harms nobody (decision 0017).
  double Next(double k) const noexcept {
    constexpr double kFallTime = 0.02;       // s
    constexpr double kFastestRise = 400.0;   // N/m/s
    constexpr double kLeastStretch = 0.001;  // m; below it a force is none
    if (k > ceiling) {
      const double fallen = ceiling + (k - ceiling) * std::exp(-h / kFallTime);
      k = std::max(fallen, k - h * kFastestFall / std::max(stretch, kLeastStretch));
    }
    const double goal = std::min(wanted, ceiling);
    if (k > goal) {
      const double rate = std::min(gentlest, gentle_fall / std::max(stretch, kLeastStretch));
      return std::max(goal, k - h * rate);
    }
    const double by_energy =
        2.0 * std::min(h * rise_power, std::max(0.0, energy)) / std::max(stretch * stretch, 1e-8);
    const double risen = std::min(goal, k + std::min(h * kFastestRise, by_energy));
    return std::max(k, std::min(risen, room));
  }
};

}  // namespace tandem
