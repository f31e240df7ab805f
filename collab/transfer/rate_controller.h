#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine/base/units.h"

namespace tandem {

/// Finds how many bytes a second a fetching program may ask for, so that the session's own packets
/// keep a free path. The rate falls while pieces come late or are lost: late pieces wait in a queue
/// that delays everybody's packets. Otherwise it rises. The class reads no clock.
class RateController {
 public:
  static constexpr double kLeast = 128e3;  // bytes/s
  static constexpr double kMost = 100e6;
  static constexpr double kFirst = 8e6;
  static constexpr std::int64_t kStepNs = 100'000'000;
  static constexpr std::int64_t kMostDelayNs = 30'000'000;  // lateness beyond the least delay
  static constexpr double kMostLost = 0.05;
  static constexpr std::size_t kLeastRoom = 4;
  static constexpr std::size_t kFirstRoom = 32;
  static constexpr std::size_t kMostRoom = 128;

  /// Takes a piece that came `delay_ns` after it was sent; the two clocks may differ by any offset.
  void OnPiece(std::int64_t delay_ns, std::size_t bytes) {
    least_ns_ = std::min(least_ns_, delay_ns);
    newer_least_ns_ = std::min(newer_least_ns_, delay_ns);
    // the least of a step: a piece delayed by a busy processor tells nothing of the network
    step_least_ns_ = std::min(step_least_ns_, delay_ns);
    ++came_;
    bytes_ += bytes;
  }
  void OnLost(std::size_t pieces) { lost_ += pieces; }

  /// Called at every turn; adapts the rate at the end of each step.
  void Tick(std::int64_t now_ns) {
    if (step_ns_ == 0) step_ns_ = least_from_ns_ = now_ns;
    if (now_ns - step_ns_ < kStepNs) return;
    const double seconds = ToSeconds(now_ns - step_ns_);
    const double got = static_cast<double>(bytes_) / seconds;
    const bool late = came_ > 0 && step_least_ns_ - least_ns_ > kMostDelayNs;
    const bool lossy = static_cast<double>(lost_) > kMostLost * static_cast<double>(came_ + lost_);
    if (late || lossy) {
      rate_ = std::max(kLeast, 0.7 * rate_);
    } else if (came_ > 0) {
      // never far beyond the received rate: the sender may be the limit
      rate_ = std::max(rate_, std::min(kMost, std::min(1.15 * rate_, 2 * got)));
    }
    room_ = std::clamp(8 * came_, kLeastRoom, kMostRoom);
    step_ns_ = now_ns;
    step_least_ns_ = kNever;
    came_ = lost_ = bytes_ = 0;
    // clocks drift, and routes change
    if (now_ns - least_from_ns_ < kLeastAgeNs) return;
    least_from_ns_ = now_ns;
    least_ns_ = newer_least_ns_;
    newer_least_ns_ = kNever;
  }
  /// Begins anew with another sender, whose clock is different.
  void Restart() {
    least_ns_ = newer_least_ns_ = step_least_ns_ = kNever;
    step_ns_ = 0;
    room_ = kFirstRoom;
    came_ = lost_ = bytes_ = 0;
  }

  double rate() const noexcept { return rate_; }
  /// Pieces that may be outstanding: most of a second's worth at the present rate.
  std::size_t room() const noexcept { return room_; }

 private:
  static constexpr std::int64_t kNever = INT64_MAX / 2;
  static constexpr std::int64_t kLeastAgeNs = 10'000'000'000;

  double rate_ = kFirst;
  std::int64_t least_ns_ = kNever;  // over the last ten seconds, or twenty
  std::int64_t newer_least_ns_ = kNever;
  std::int64_t least_from_ns_ = 0;
  std::int64_t step_ns_ = 0;
  std::int64_t step_least_ns_ = kNever;
  std::size_t room_ = kFirstRoom;
  std::size_t came_ = 0;
  std::size_t lost_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace tandem
