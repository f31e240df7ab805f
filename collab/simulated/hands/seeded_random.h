#pragma once

#include <cstdint>
#include <random>

#include "engine/base/spatial.h"

namespace tandem {

/// Draws from a seed. The same calls give the same numbers on every machine.
class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed) : random_(seed * 0x9E3779B97F4A7C15U + 1) {}

  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1p-53;
  }
  std::int64_t Whole(std::int64_t low, std::int64_t high) {  // both included
    return low + static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool Chance(double chance) { return Uniform(0, 1) < chance; }
  /// Draws a place in a cube about the origin.
  Vec3 Place(double half) {
    const double x = Uniform(-half, half);
    const double y = Uniform(-half, half);
    return {x, y, Uniform(-half, half)};
  }
  Quat Turn(double most) {
    const Vec3 axis = Place(1) + Vec3(0, 0, 1e-6);
    return Quat(Eigen::AngleAxisd(Uniform(-most, most), axis.normalized()));
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace tandem
