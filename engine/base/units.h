#pragma once

#include <cstdint>

namespace tandem {

/// Nanoseconds in a millisecond: times between threads and peers are whole nanoseconds.
inline constexpr std::int64_t kMs = 1'000'000;
/// Nanoseconds in a second.
inline constexpr std::int64_t kSecondNs = 1'000'000'000;

constexpr double ToSeconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

}  // namespace tandem
