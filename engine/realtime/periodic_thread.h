#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <latch>
#include <thread>

#include "engine/realtime/clock.h"
#include "engine/realtime/frame_stats.h"
#include "engine/realtime/realtime_setup.h"

namespace tandem {

/// A frame of a loop. It gets its number, from 0 without gaps, and the time at which it starts
/// (monotonic, ns). It returns false to end the loop. Must not throw.
using PeriodicFrame = std::function<bool(std::int64_t frame, std::int64_t now_ns)>;

/// Called after each frame, which began at `start_ns` and ended at `end_ns` while the thread
/// computed for `cpu_ns`. So the frame need not ask for the processor's time, which costs a system
/// call. Must not throw.
using FrameDone =
    std::function<void(std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns)>;

/// Runs `frame` at future deadlines origin + k * period, until it returns false or `stop` is set.
/// Deadlines that pass before a frame has ended are skipped and counted, never caught up: the next
/// frame starts at the next future deadline. The loop itself allocates nothing.
void RunPeriodically(std::int64_t period_ns, std::int64_t origin_ns, const PeriodicFrame& frame,
                     const std::atomic<bool>& stop, LoopClock& clock, FrameStats& stats,
                     const FrameDone& done = {}) noexcept;

/// A thread that does so on the machine's clock, real-time where that is allowed.
class PeriodicThread {
 public:
  struct Options {
    std::int64_t period_ns = 1'000'000;
    /// Origin of the deadlines, monotonic, for threads that keep a distance in time; 0: the start.
    std::int64_t origin_ns = 0;
    /// Priority under SCHED_FIFO; 0: an ordinary thread, only whose sleeps are exact.
    int priority = 30;
    int core = -1;               // core that the thread stays on; below 0: any
    const char* name = nullptr;  // name in debuggers and top, 15 characters; null: the program's
  };

  /// Returns once the thread runs and its status is known.
  PeriodicThread(const Options& options, PeriodicFrame frame, FrameDone done = {});
  /// Stops and joins the thread.
  ~PeriodicThread();
  PeriodicThread(const PeriodicThread&) = delete;
  PeriodicThread& operator=(const PeriodicThread&) = delete;

  /// Asks the loop to end after the current frame. For any thread, and signal handlers.
  void Stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  /// Waits for the loop's end.
  void Join();

  const RealtimeStatus& realtime() const noexcept { return realtime_; }
  /// Returns the statistics; only after Join().
  const FrameStats& stats() const;

 private:
  PeriodicFrame frame_;
  FrameDone done_;
  std::atomic<bool> stop_{false};
  RealtimeStatus realtime_;
  FrameStats stats_;
  std::latch entered_{1};
  std::thread thread_;
};

}  // namespace tandem
