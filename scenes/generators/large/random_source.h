#pragma once

#include <cstdint>

namespace tandem {

/// Draws random numbers, the same ones on every machine for the same seed (splitmix64). Compilers
/// choose the order of two that are arguments of one call; in braces they come as written.
class RandomSource {
 public:
  explicit RandomSource(std::uint64_t seed) : state_(seed) {}

  std::uint64_t Next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
  }
  /// Returns a number evenly from [low, high).
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(Next() >> 11U) * 0x1p-53;
  }
  /// Returns a number evenly from low, low + 1, … high.
  int Whole(int low, int high) {
    return low + static_cast<int>(Next() % static_cast<std::uint64_t>(high - low + 1));
  }

 private:
  std::uint64_t state_;
};

}  // namespace tandem
