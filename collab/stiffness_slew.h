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
  double told = 1e30;      // N/m that the other end uses: above, it falls as above the ceiling
  double room = 0;         // N/m that it may rise to, as the other links leave it
  double gentlest = 1e30;  // N/m/s: a gentle fall is not faster than this
  double gentle_fall = kGentleFall;  // N/s that such a fall may take
  double rise_power = kRisePower;    // W that a rise may put into the spring
  double energy = 1e30;              // J that a rise may put into the spring now
  double speed = 1e30;               // m/s, of the faster of the two instances
  bool falls_unfelt = false;         // falls move what hands hold apart too slowly to be felt
  bool rises_unfelt = false;         // rises likewise

  /// A rise puts dk stretch^2/2 into the spring, which is bounded. A fall takes energy out, so it
  /// may be as fast as the delay wants; where its cause is only that nobody answers, or that one
  /// more has come, it is gentle: a held copy is a fixed anchor and harms nobody (decision 0017).
  double Next(double k) const noexcept {
    constexpr double kFallTime = 0.02;       // s
    constexpr double kFastestRise = 400.0;   // N/m/s
    constexpr double kLeastStretch = 0.001;  // m; below it a force is none
    const double own = std::min(wanted, ceiling);
    const double goal = std::min(own, told);
    const double most = std::min(ceiling, told);
    double slowest = 0;  // that it need not fall below
    if (falls_unfelt) {
      slowest = std::min(told, k - MostUnfelt(k, k / std::max(own, 1e-9) / kFirmerAtRest));
    }
    if (k > most) {
      const double fallen = most + (k - most) * std::exp(-h / kFallTime);
      k = std::max({fallen, k - h * kFastestFall / std::max(stretch, kLeastStretch), slowest});
    }
    if (k > goal) {
      const double rate = std::min(gentlest, gentle_fall / std::max(stretch, kLeastStretch));
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
  static constexpr double kFirmerAtRest = 2.0;   // than the ceiling, at rest: it falls slowly
  static constexpr double kSofterAtRest = 10.0;  // than wanted: it rises slowly

  /// The change of the stiffness k in a frame (N/m) by which a part that hands pull apart moves so
  /// slowly that nobody feels it, or not faster than it moves anyway: where the force stays, the
  /// stretch changes as the stiffness does. Beyond the share that a spring may be off at rest
  /// (`excess` above 1) it may be faster, by a high power of that.
  double MostUnfelt(double k, double excess) const noexcept {
    constexpr double kUnfelt = 2e-5;     // m/s
    constexpr double kMoving = 4e-3;     // m/s: beyond, a hand moves the part
    constexpr double kNoStretch = 1e-6;  // m
    const double beyond = std::max(1.0, excess);
    const double square = beyond * beyond;
    const double share = speed / kMoving;
    const double slide = (kUnfelt + speed * (0.25 + share * share)) * square * square * square;
    return h * k * slide / std::max(stretch, kNoStretch);
  }
};

}  // namespace tandem
