#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace tandem::testing {

/// Measures how late this machine wakes an ordinary thread, beside a test that has a bound on time.
/// On a quiet machine it is less than a millisecond.
class LagMeter {
 public:
  using Clock = std::chrono::steady_clock;

  LagMeter()
      : thread_([this] {
          while (!stop_) {
            const Clock::time_point due = Clock::now() + std::chrono::milliseconds(1);
            std::this_thread::sleep_until(due);
            const Clock::duration late = Clock::now() - due;
            worst_ = std::max(worst_.load(), late.count());
          }
        }) {}
  ~LagMeter() {
    stop_ = true;
    thread_.join();
  }
  LagMeter(const LagMeter&) = delete;
  LagMeter& operator=(const LagMeter&) = delete;

  /// Returns the latest that it was so far.
  Clock::duration worst() const { return Clock::duration(worst_.load()); }
  /// Returns the bound, and as much more as the machine was late at the worst.
  Clock::duration AllowedLag(Clock::duration bound) const { return bound + worst(); }

 private:
  std::atomic<bool> stop_ = false;
  std::atomic<Clock::rep> worst_ = 0;
  std::thread thread_;
};

}  // namespace tandem::testing
