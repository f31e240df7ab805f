#pragma once

#include <cstdint>

namespace tandem {

/// Nanoseconds in a millisecond: times between threads and peers are whole nanoseconds.
inline constexpr std::int64_t kMs = 1'000'000;

}  // namespace tandem
