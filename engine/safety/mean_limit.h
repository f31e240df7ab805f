#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem {

/// Keeps the mean of a force over any ten seconds within what a motor bears for ever. What may be
/// given falls with what is left of the ten seconds' budget, so that the force fades and does not
/// drop. The same for a moment.
class MeanLimit {
 public:
  static constexpr std::int64_t kWindowNs = 10'000'000'000;

  /// `continuous`: what the motor bears for ever; `peak`: what it may give for a while.
  MeanLimit(double continuous, double peak) noexcept;

  /// What may be given in the coming step.
  double Allowed() const noexcept;
  /// That `size` was given for so long.
  void Gave(double size, std::int64_t for_ns) noexcept;

 private:
  static constexpr std::size_t kSlots = 1000;
  static constexpr std::int64_t kSlotNs = kWindowNs / kSlots;
  static constexpr double kFadeShare = 0.2;  // of the budget, over whose end the peak fades

  double continuous_;
  double peak_;
  // one more than the window has: the oldest is partly out of it and counts whole
  std::array<double, kSlots + 1> slots_{};  // N s
  double sum_ = 0;                          // of them
  std::size_t slot_ = 0;
  std::int64_t in_slot_ns_ = 0;
};

}  // namespace tandem
