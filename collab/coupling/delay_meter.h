#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/units.h"

namespace tandem {

/// Measures the age of the loop between two peers. The newest own sample that the other peer's
/// `echo` reports was taken that long ago. Holding, jitter and loss are part of it. Clocks of two
/// machines are never compared. Used by the haptic thread alone.
///
/// Gains must hold for the worst age of the near future, so the meter keeps the largest age of the
/// past two seconds, exact to the frame. DesignDelay() adds a tenth and 5 ms as a margin.
class DelayMeter {
 public:
  /// `loop_age_ns`: now minus the newest echo.
  void Add(std::int64_t now_ns, std::int64_t loop_age_ns) noexcept {
    while (count_ > 0 && At(count_ - 1).age_ns <= loop_age_ns) --count_;
    if (count_ == kMost) {  // full: the smallest age stays longer
      At(count_ - 1).at_ns = now_ns;
    } else {
      At(count_++) = {now_ns, loop_age_ns};
    }
    Forget(now_ns);
  }

  /// Forgets the ages older than two seconds, except the newest.
  void Forget(std::int64_t now_ns) noexcept {
    while (count_ > 1 && now_ns - At(0).at_ns > kHoldNs) {
      first_ = (first_ + 1) % kMost;
      --count_;
    }
  }

  void Clear() noexcept { count_ = 0; }

  double peak_loop_age_s() const noexcept {
    return count_ == 0 ? 0.0 : ToSeconds(ages_[first_].age_ns);
  }

 private:
  static constexpr std::int64_t kHoldNs = 2'000'000'000;
  static constexpr std::size_t kMost = 256;

  struct Age {
    std::int64_t at_ns = 0;
    std::int64_t age_ns = 0;
  };
  Age& At(std::size_t i) noexcept { return ages_[(first_ + i) % kMost]; }

  std::array<Age, kMost> ages_{};  // ring; each age is less than the ones stored earlier
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace tandem
