#pragma once

#include <cmath>
#include <cstdint>

namespace tandem {

/// Counts the states that a peer sent and the states due in that time. States that its own threads
/// were too late to send are missing as well, and no receiver can know of them.
class SentStates {
 public:
  /// Counts a state sent at `now_ns`; the next is due a period later. A gap of half a second or
  /// more means an empty hand.
  void Add(std::int64_t now_ns, std::int64_t period_ns) noexcept {
    const std::int64_t since = now_ns - last_ns_;
    const bool on = sent_ > 0 && since < kPause;
    wanted_ += on ? static_cast<double>(since) / static_cast<double>(period_ns) : 1.0;
    ++sent_;
    last_ns_ = now_ns;
  }

  std::uint64_t sent() const noexcept { return sent_; }
  std::uint64_t wanted() const noexcept {
    return static_cast<std::uint64_t>(std::llround(wanted_));
  }

 private:
  static constexpr std::int64_t kPause = 500'000'000;

  std::int64_t last_ns_ = 0;
  std::uint64_t sent_ = 0;
  double wanted_ = 0;
};

}  // namespace tandem
