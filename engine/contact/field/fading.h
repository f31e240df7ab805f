#pragma once

#include <algorithm>

namespace tandem {

/// Returns 1 up to one angle and 0 from another on, by their cosines or sines.
inline double Fading(double value, double full, double none) noexcept {
  return std::clamp((value - none) / (full - none), 0.0, 1.0);
}

}  // namespace tandem
