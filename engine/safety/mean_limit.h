#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem {

/// Keeps the mean of a force over any ten seconds within what a motor bears for ever. The allowed
/// force falls with the rest of the ten seconds' budget, so that the force fades and does not drop.
/// The same for a moment.
class MeanLimit {
 public:
  static constexpr std::int64_t kWindowNs = 10'000'000'000;

  /// `continuous`: force that the motor bears for ever; `peak`: force that it may give for a while.
  MeanLimit(double continuous, double peak) noexcept;

  /// Returns the force that may be given in the coming step.
  double Allowed() const noexcept;
  /// Notes that the force `size` was given for `for_ns`.
  void RecordForce(double size, std::int64_t for_ns) noexcept;

 private:
  static constexpr std::size_t kSlots = 1000;
  static constexpr std::int64_t kSlotNs = kWindowNs / kSlots;
  static constexpr double kFadeShare = 0.2;  // share of the budget at whose end the peak fades

  double continuous_;
  double peak_;
  // one more than the window has: the oldest slot is partly outside and counts whole
  std::array<double, kSlots + 1> slots_{};  // N s
  double sum_ = 0;                          // sum of the slots
  std::size_t slot_ = 0;
  std::int64_t in_slot_ns_ = 0;
};

}  // namespace tandem
