#pragma once

#include <algorithm>
#include <cmath>

namespace tandem {

inline constexpr double kFadeTime = 0.2;    // s; shortest fade of a peer that is gone
inline constexpr double kGentleFall = 8.0;  // N/s; gentle falls take no more from the links' forces
inline constexpr double kCappedFall = 10.0;    // N/s; likewise, where users are told of the cause
inline constexpr double kRisePower = 0.02;     // W; rises put at most this into the links' springs
inline constexpr double kFastestFall = 800.0;  // N/s; limit of any fall

/// Returns the drag after `h` seconds on its way to `to`: up at once, down gently. The delay that
/// gains are made for falls at once when its peak is two seconds old; more drag than needed is
/// safe.
inline double DragAfter(double h, double from, double to) noexcept {
  constexpr double kMostDragFall = 100.0;  // N s/m per second; fastest fall of any drag
  return std::max(to, from - h * kMostDragFall);
}

/// Limits the change of a link's stiffness in a frame of `h` seconds.
struct StiffnessLimiter {
  double h = 1e-3;         // s
  double stretch = 0;      // m; of the spring: sqrt(|d|^2 + theta^T (I/m) theta)
  double ceiling = 0;      // N/m that the delay allows; above it k falls in 20 ms, or little longer
  double wanted = 0;       // N/m; target, at most the ceiling
  double reported = 1e30;  // N/m that the other end uses; above it k falls likewise
  double room = 0;         // N/m; most that k may rise to, as the other links leave it
  double fastest_gentle_fall = 1e30;  // N/m/s; fastest gentle fall
  double gentle_fall = kGentleFall;   // N/s; force that a gentle fall may take
  double rise_power = kRisePower;     // W; most power of a rise into the spring
  double energy = 1e30;               // J; most energy of a rise into the spring now
  double speed = 1e30;                // m/s; speed of the faster instance
  bool falls_unfelt = false;  // falls are too slow to be felt where hands hold the instances apart
  bool rises_unfelt = false;  // the same for rises

  /// Returns the stiffness after the frame. A rise puts dk stretch^2/2 into the spring, so it is
  /// bounded. A fall takes energy out, so it may be as fast as the delay requires. If its cause is
  /// only a silent or an additional peer, it is gentle: a held copy is a fixed anchor and harms
  /// nobody (decision 0017).
  double Next(double k) const noexcept {
    constexpr double kFallTime = 0.02;       // s
    constexpr double kFastestRise = 400.0;   // N/m/s
    constexpr double kLeastStretch = 0.001;  // m; the force counts as none below it
    const double own = std::min(wanted, ceiling);
    const double goal = std::min(own, reported);
    const double most = std::min(ceiling, reported);
    double slowest = 0;  // k need not fall below it
    if (falls_unfelt) {
      slowest = std::min(reported, k - MostUnfelt(k, k / std::max(own, 1e-9) / kFirmerAtRest));
    }
    if (k > most) {
      const double fallen = most + (k - most) * std::exp(-h / kFallTime);
      k = std::max({fallen, k - h * kFastestFall / std::max(stretch, kLeastStretch), slowest});
    }
    if (k > goal) {
      const double rate =
          std::min(fastest_gentle_fall, gentle_fall / std::max(stretch, kLeastStretch));
      return std::max({goal, k - h * rate, slowest});
    }
    const double by_energy =
        2.0 * std::min(h * rise_power, std::max(0.0, energy)) / std::max(stretch * stretch, 1e-8);
    const double unfelt =
        rises_unfelt ? MostUnfelt(k, goal / std::max(k, 1e-9) / kSofterAtRest) : 1e30;
    const double risen = std::min(goal, k + std::min({h * kFastestRise, by_energy, unfelt}));
    return std::max(k, std::min(risen, room));
  }

 private:
  static constexpr double kFirmerAtRest = 2.0;   // at rest k falls slowly while below this * goal
  static constexpr double kSofterAtRest = 10.0;  // at rest k rises slowly while above goal / this

  /// Returns the greatest change of k in a frame (N/m) that hands do not feel. At constant force
  /// the stretch changes as the stiffness does; a body that hands pull apart then moves too slowly
  /// to be felt, or no faster than it moves anyway. Beyond the factor allowed at rest (`excess`
  /// above 1) the change may be faster, by a high power of the excess.
  double MostUnfelt(double k, double excess) const noexcept {
    constexpr double kUnfelt = 2e-5;     // m/s
    constexpr double kMoving = 4e-3;     // m/s; above it a hand moves the body
    constexpr double kNoStretch = 1e-6;  // m
    const double beyond = std::max(1.0, excess);
    const double square = beyond * beyond;
    const double share = speed / kMoving;
    const double slide = (kUnfelt + speed * (0.25 + share * share)) * square * square * square;
    return h * k * slide / std::max(stretch, kNoStretch);
  }
};

}  // namespace tandem
