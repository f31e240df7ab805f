#pragma once

#include <cstdint>
#include <string>

#include "engine/realtime/histogram.h"

namespace tandem {

/// Statistics of how a periodic loop kept its time. The loop's thread writes them. Other threads
/// read them after it has been joined.
class FrameStats {
 public:
  /// Adds a frame. `lateness_ns`: from its deadline to its start. `cpu_ns`, `wall_ns`: from its
  /// start to its end. `skipped`: the deadlines that passed before its end and get no frame.
  void Add(std::int64_t lateness_ns, std::int64_t cpu_ns, std::int64_t wall_ns,
           std::int64_t skipped) noexcept;

  std::uint64_t frames() const noexcept { return wall_.count(); }
  std::uint64_t missed() const noexcept { return missed_; }  // deadlines skipped

  const Histogram& cpu() const noexcept { return cpu_; }
  const Histogram& wall() const noexcept { return wall_; }
  const Histogram& lateness() const noexcept { return lateness_; }

  /// Returns one line for a person: frames, missed, and p50 / p99 / max of each time in
  /// microseconds.
  std::string Summary() const;

 private:
  Histogram cpu_;
  Histogram wall_;
  Histogram lateness_;
  std::uint64_t missed_ = 0;
};

}  // namespace tandem
