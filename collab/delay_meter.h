#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace tandem {

/// The age of the loop between two peers: how long ago the newest own sample was taken that has
/// come back to us in what the other says it holds (`echo`). Holding, jitter and loss are in it; no
/// clock is compared with another's. Used by the haptic thread alone.
///
/// Gains must hold for the worst age of the near future, so the largest of the past two seconds is
/// kept (notes: the peak under-estimates the next second's worst in 2 to 6 % of cases, the mean in
/// all).
class DelayMeter {
 public:
  /// `loop_age_ns`: now minus the newest echo.
  void Add(std::int64_t now_ns, std::int64_t loop_age_ns) noexcept {
    const std::int64_t slot = now_ns / kSlotNs;
    const bool turns = slot != slot_;
    if (turns) {
      // slots that passed without a sample hold nothing
      const std::int64_t passed = std::min<std::int64_t>(slot - slot_, kSlots);
      for (std::int64_t i = 1; i <= passed; ++i) peaks_[Index(slot_ + i)] = 0;
      slot_ = slot;
    }
    peaks_[Index(slot)] = std::max(peaks_[Index(slot)], loop_age_ns);
    peak_ = turns ? *std::max_element(peaks_.begin(), peaks_.end()) : std::max(peak_, loop_age_ns);
  }

  double peak_loop_age_s() const noexcept { return 1e-9 * static_cast<double>(peak_); }

 private:
  static constexpr std::int64_t kSlotNs = 100'000'000;
  static constexpr std::int64_t kSlots = 20;

  static std::size_t Index(std::int64_t slot) noexcept {
    return static_cast<std::size_t>(slot % kSlots);
  }

  std::array<std::int64_t, kSlots> peaks_{};
  std::int64_t peak_ = 0;  // of them
  std::int64_t slot_ = 0;
};

}  // namespace tandem
