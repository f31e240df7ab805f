#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tandem {

/// Counts of durations (ns) in bins that grow with the value, in fixed memory (15 kB): exact below
/// 64 ns, above that within 1/64 of the value. Negative durations count as 0. Add() allocates
/// nothing.
class Histogram {
 public:
  void Add(std::int64_t value_ns) noexcept {
    const std::int64_t value = std::max<std::int64_t>(value_ns, 0);
    ++bins_[BinOf(static_cast<std::uint64_t>(value))];
    ++count_;
    max_ = std::max(max_, value);
  }

  std::uint64_t count() const noexcept { return count_; }
  std::int64_t max() const noexcept { return max_; }  // exact; 0 when empty

  /// Returns the least value (ns) that at least a share `q` in [0, 1] of all values does not
  /// exceed; 0 when empty.
  std::int64_t Quantile(double q) const noexcept {
    if (count_ == 0) return 0;
    const double wanted = std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_));
    const std::uint64_t rank = std::max<std::uint64_t>(static_cast<std::uint64_t>(wanted), 1);
    if (rank >= count_) return max_;
    std::uint64_t seen = 0;
    std::size_t bin = 0;
    while ((seen += bins_[bin]) < rank) ++bin;
    return std::min(MiddleOf(bin), max_);
  }

 private:
  // Values up to 2 * kSteps have a bin each; every further power of two has kSteps bins.
  static constexpr unsigned kStepBits = 5;
  static constexpr std::size_t kSteps = std::size_t{1} << kStepBits;
  static constexpr std::size_t kBins = (64 - kStepBits) * kSteps;

  static constexpr std::size_t BinOf(std::uint64_t value) noexcept {
    const auto width = static_cast<unsigned>(std::bit_width(value));
    if (width <= kStepBits + 1) return static_cast<std::size_t>(value);
    const unsigned shift = width - (kStepBits + 1);
    return shift * kSteps + static_cast<std::size_t>(value >> shift);
  }
  static constexpr std::int64_t MiddleOf(std::size_t bin) noexcept {
    if (bin < 2 * kSteps) return static_cast<std::int64_t>(bin);
    const std::size_t shift = bin / kSteps - 1;
    const std::uint64_t low = static_cast<std::uint64_t>(bin - shift * kSteps) << shift;
    return static_cast<std::int64_t>(low + (std::uint64_t{1} << (shift - 1)));
  }

  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t max_ = 0;
};

}  // namespace tandem
