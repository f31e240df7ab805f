#include "engine/realtime/periodic_thread.h"

#include <string>
#include <utility>

#include <sys/prctl.h>

#include "engine/base/check.h"

namespace tandem {

void RunPeriodically(std::int64_t period_ns, std::int64_t origin_ns, const PeriodicFrame& frame,
                     const std::atomic<bool>& stop, LoopClock& clock, FrameStats& stats,
                     const FrameDone& done) noexcept {
  TANDEM_CHECK(period_ns > 0);
  const std::int64_t now = clock.NowNs();
  const std::int64_t passed = now > origin_ns ? (now - origin_ns) / period_ns : 0;
  std::int64_t deadline = origin_ns + (passed + 1) * period_ns;
  for (std::int64_t number = 0;; ++number) {
    clock.SleepUntil(deadline);
    if (stop.load(std::memory_order_relaxed)) return;

    const std::int64_t start = clock.NowNs();
    const std::int64_t cpu_start = clock.ThreadCpuNs();
    const bool goes_on = frame(number, start);
    const std::int64_t cpu_end = clock.ThreadCpuNs();
    const std::int64_t end = clock.NowNs();

    const std::int64_t skipped = end > deadline ? (end - deadline) / period_ns : 0;
    stats.Add(start - deadline, cpu_end - cpu_start, end - start, skipped);
    if (done) done(start, end, cpu_end - cpu_start);
    if (!goes_on) return;
    deadline += (skipped + 1) * period_ns;
  }
}

PeriodicThread::PeriodicThread(const Options& options, PeriodicFrame frame, FrameDone done)
    : frame_(std::move(frame)), done_(std::move(done)) {
  thread_ = std::thread([this, options] {
    if (options.name != nullptr) prctl(PR_SET_NAME, options.name);
    const bool kept = options.core < 0 || KeepToCore(options.core);
    if (options.priority > 0) {
      realtime_ = EnterRealtime(options.priority);
    } else {
      realtime_.timer_slack = prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0;
    }
    if (!kept) {
      realtime_.warning += (realtime_.warning.empty() ? "" : "; ");
      realtime_.warning += "core " + std::to_string(options.core) + " cannot be had";
    }
    realtime_.core = kept ? options.core : -1;
    entered_.count_down();
    LoopClock& clock = MachineClock();
    const std::int64_t origin_ns = options.origin_ns > 0 ? options.origin_ns : clock.NowNs();
    RunPeriodically(options.period_ns, origin_ns, frame_, stop_, clock, stats_, done_);
  });
  entered_.wait();
}

PeriodicThread::~PeriodicThread() {
  Stop();
  if (thread_.joinable()) thread_.join();
}

void PeriodicThread::Join() {
  if (thread_.joinable()) thread_.join();
}

const FrameStats& PeriodicThread::stats() const {
  TANDEM_CHECK(!thread_.joinable());
  return stats_;
}

}  // namespace tandem
