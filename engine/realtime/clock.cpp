#include "engine/realtime/clock.h"

#include <cerrno>
#include <ctime>

#include "engine/base/units.h"

namespace tandem {
namespace {

std::int64_t ReadClock(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<std::int64_t>(t.tv_sec) * kSecondNs + t.tv_nsec;
}

class MachineLoopClock final : public LoopClock {
 public:
  std::int64_t NowNs() noexcept override { return ReadClock(CLOCK_MONOTONIC); }
  std::int64_t ThreadCpuNs() noexcept override { return ReadClock(CLOCK_THREAD_CPUTIME_ID); }
  void SleepUntil(std::int64_t deadline_ns) noexcept override {
    timespec t{};
    t.tv_sec = static_cast<time_t>(deadline_ns / kSecondNs);
    t.tv_nsec = static_cast<long>(deadline_ns % kSecondNs);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
    }
  }
};

}  // namespace

std::int64_t MonotonicNowNs() noexcept {
  return ReadClock(CLOCK_MONOTONIC);
}

std::int64_t SleptNs() noexcept {
  return ReadClock(CLOCK_BOOTTIME) - ReadClock(CLOCK_MONOTONIC);
}

LoopClock& MachineClock() noexcept {
  static MachineLoopClock clock;
  return clock;
}

}  // namespace tandem
