#pragma once

#include <cmath>
#include <cstdint>

namespace tandem {

/// How many states a peer sent, beside how many it was to send in that time: what its own threads
/// came too late for is missing too, and no receiver can know of it.
class SentStates {
 public:
  /// One was sent at that time; the next is due a period later. After half a second without any the
  /// hand was empty.
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
