#pragma once

#include <cstdint>

#include "engine/realtime/frame_stats.h"

namespace tandem {

/// Keeps statistics of a periodic loop's frames in which the hand moves, from within the loop.
/// Frames before and after have less to do. One thread uses it; others read it once that thread has
/// ended.
class JudgedFrames {
 public:
  /// Deadlines of the loop are origin + k * period.
  JudgedFrames(std::int64_t origin_ns, std::int64_t period_ns) noexcept
      : origin_ns_(origin_ns), period_ns_(period_ns) {}

  /// Counts a frame that began at `start_ns` and ended at `end_ns`. `judged`: the hand moves in it.
  /// Call it after each frame of the loop.
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
  /// Returns the number of judged frames that by themselves took longer than the loop's period.
  std::uint64_t over_period() const noexcept { return over_period_; }

 private:
  std::int64_t origin_ns_;
  std::int64_t period_ns_;
  std::int64_t last_ = 0;  // deadline of the previous frame
  bool judged_before_ = false;
  FrameStats stats_;
  std::uint64_t over_period_ = 0;
};

}  // namespace tandem
