#pragma once

#include <cmath>

namespace tandem {

/// Returns a value to two digits, and no more than the value; 0 unless it is above 0.
inline double DownToTwoDigits(double value) {
  if (!(value > 0)) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return unit * std::floor(value / unit + 1e-3);
}

}  // namespace tandem
