#pragma once

#include <cstdint>

namespace tandem {

/// This machine's monotonic clock (ns). Only engine/realtime and collab/dds read clocks; the rest
/// is told the time.
std::int64_t MonotonicNowNs() noexcept;

/// How long this machine has slept since it was started, ns: suspended, when its monotonic clock
/// stands still.
std::int64_t SleptNs() noexcept;

/// Where a loop has its time from: the machine's clocks in the product, a scripted clock in tests.
/// Used by the loop's thread alone.
class LoopClock {
 public:
  virtual ~LoopClock() = default;
  /// Monotonic (ns).
  virtual std::int64_t NowNs() noexcept = 0;
  /// Processor time that the calling thread has used (ns).
  virtual std::int64_t ThreadCpuNs() noexcept = 0;
  /// Returns when NowNs() is at least `deadline_ns`; at once if it is already.
  virtual void SleepUntil(std::int64_t deadline_ns) noexcept = 0;
};

/// The machine's clocks, for any thread.
LoopClock& MachineClock() noexcept;

}  // namespace tandem
