#pragma once

#include <cstdint>

#include "engine/realtime/frame_stats.h"

namespace tandem {

/// Statistics of some of a periodic loop's frames, from within the loop: those in which the hand
/// moves, for frames before and after have less to do. Used by one thread; read once that has
/// ended.
class JudgedFrames {
 public:
  /// Deadlines of the loop are origin + k * period.
  JudgedFrames(std::int64_t origin_ns, std::int64_t period_ns) noexcept
      : origin_ns_(origin_ns), period_ns_(period_ns) {}

  /// After each frame of the loop, which started at `start_ns` and ends at `end_ns`.
  void Add(bool judged, std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns) noexcept {
    const std::int64_t since = start_ns - origin_ns_;
    const std::int64_t deadline = since / period_ns_;
    const std::int64_t skipped = judged_before_ ? deadline - last_ - 1 : 0;
    if (judged) {
      stats_.Add(since % period_ns_, cpu_ns, end_ns - start_ns, skipped);
      over_period_ += end_ns - start_ns > period_ns_ ? 1U : 0U;
    }
    last_ = deadline;
    judged_before_ = judged;
  }

  const FrameStats& stats() const noexcept { return stats_; }
  /// Frames that by themselves took longer than the loop's period.
  std::uint64_t over_period() const noexcept { return over_period_; }

 private:
  std::int64_t origin_ns_;
  std::int64_t period_ns_;
  std::int64_t last_ = 0;  // deadline of the frame before
  bool judged_before_ = false;
  FrameStats stats_;
  std::uint64_t over_period_ = 0;
};

}  // namespace tandem
