#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace tandem {

/// Keeps the stamps of our last `kKept` samples, so that an echo can be told from an invented
/// number. Used by the haptic thread alone.
template <std::uint64_t kKept>
class StampRing {
 public:
  void Add(std::int64_t sample_ns) noexcept {
    if (count_ > 0 && sample_ns <= At(count_ - 1)) return;
    stamps_[count_ % kKept] = sample_ns;
    ++count_;
  }
  /// Forgets all stamps.
  void Clear() noexcept { count_ = 0; }
  bool Has(std::int64_t sample_ns) const noexcept {
    std::uint64_t low = count_ > kKept ? count_ - kKept : 0;
    std::uint64_t high = count_;
    // an echo is mostly some milliseconds old: search back from the newest stamp, in growing steps
    for (std::uint64_t step = 1; high - low > step; step *= 2) {
      if (At(high - step) <= sample_ns) {
        low = high - step;
        break;
      }
      high -= step;
    }
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      if (At(middle) < sample_ns) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low < count_ && At(low) == sample_ns;
  }

 private:
  std::int64_t At(std::uint64_t number) const noexcept { return stamps_[number % kKept]; }

  std::array<std::int64_t, kKept> stamps_{};
  std::uint64_t count_ = 0;
};

using SentStamps = StampRing<4096>;  // more than four seconds at 1 kHz

}  // namespace tandem
