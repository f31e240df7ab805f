#pragma once

#include <cstdint>

namespace tandem {

/// Returns this machine's monotonic clock (ns). Only engine/realtime and collab/dds read clocks;
/// all other code gets the time as an argument.
std::int64_t MonotonicNowNs() noexcept;

/// Returns how long this machine has slept since its start, ns: suspended, with its monotonic clock
/// standing still.
std::int64_t SleptNs() noexcept;

/// The source of a loop's time: the machine's clocks in the product, a scripted clock in tests.
/// Used by the loop's thread alone.
class LoopClock {
 public:
  virtual ~LoopClock() = default;
  /// Returns the monotonic time (ns).
  virtual std::int64_t NowNs() noexcept = 0;
  /// Returns the processor time that the calling thread has used (ns).
  virtual std::int64_t ThreadCpuNs() noexcept = 0;
  /// Returns when NowNs() is at least `deadline_ns`; at once if it is already.
  virtual void SleepUntil(std::int64_t deadline_ns) noexcept = 0;
};

/// The machine's clocks, for any thread.
LoopClock& MachineClock() noexcept;

}  // namespace tandem
