#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "app/device/drivers/fake/fake_record.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/safety/motor_guard.h"

namespace tandem::testing {

inline constexpr double kClamp = kUsersDefault.force;
inline constexpr double kSlew = kClamp / MotorGuard::kSlewTicks;

inline void Sleep(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Reads a motor's writes, as the driver `fake` keeps them in a file.
class Motor {
 public:
  explicit Motor(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    EXPECT_EQ(ftruncate(descriptor, sizeof(FakeRecord)), 0);
    void* data =
        mmap(nullptr, sizeof(FakeRecord), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    close(descriptor);
    EXPECT_NE(data, MAP_FAILED);
    record_ = static_cast<FakeRecord*>(data);
  }
  Motor(const Motor&) = delete;
  ~Motor() { munmap(record_, sizeof(FakeRecord)); }

  std::uint64_t count() const { return record_->count.load(std::memory_order_acquire); }
  std::vector<FakeRecord::Write> WritesSince(std::uint64_t first) const {
    std::vector<FakeRecord::Write> writes;
    for (std::uint64_t i = first; i < count(); ++i) {
      writes.push_back(record_->writes[i % FakeRecord::kRoom]);
    }
    return writes;
  }
  static double ForceOf(const FakeRecord::Write& write) {
    return std::hypot(write.force_N[0], write.force_N[1], write.force_N[2]);
  }
  double force() const {
    const std::uint64_t written = count();
    return written == 0 ? 0 : ForceOf(record_->writes[(written - 1) % FakeRecord::kRoom]);
  }
  bool WaitForForce(double force_N, double seconds = 20) const {
    for (int i = 0; i < 1000 * seconds && force() < force_N; ++i) Sleep(1e-3);
    return force() >= force_N;
  }
  /// Waits until there is no force, and then long enough to see that it stays so. A process of the
  /// device that itself stands still makes it late.
  void WaitForTheFall() const {
    for (int i = 0; i < 5000 && force() > 0; ++i) Sleep(1e-3);
    Sleep(0.03);
  }
  /// Returns whether nobody writes to the motor any more, within 20 s.
  bool WaitForNoWrites() const {
    std::uint64_t written = count();
    for (int i = 0; i < 1000; ++i) {
      Sleep(0.02);
      if (count() == written) return true;
      written = count();
    }
    return false;
  }
  /// Waits until there is no force for half a second: a machine that is late may take it away for
  /// some 150 ms before that.
  void WaitForNoForce() const {
    int quiet_ms = 0;
    for (int i = 0; i < 10'000 && quiet_ms < 500; ++i) {
      Sleep(1e-3);
      quiet_ms = force() > 0 ? 0 : quiet_ms + 1;
    }
  }

 private:
  FakeRecord* record_ = nullptr;
};

/// Runs a loop that does nothing beside the test, and keeps how late this machine made it at the
/// worst. This lateness excuses a device's loop, whose own lateness does not.
class EmptyLoop {
 public:
  EmptyLoop()
      : thread_({.priority = 40}, [](std::int64_t, std::int64_t) {
          return true;
        }) {}
  double WorstMs() {
    thread_.Stop();
    thread_.Join();
    return 1e-6 * static_cast<double>(thread_.stats().lateness().max());
  }

 private:
  PeriodicThread thread_;
};

/// The fall of the force after the controller was gone.
struct Fall {
  double held_N = 0;      // force as the controller went
  double damping_ms = 0;  // time until the fall began
  double zero_ms = 0;     // time until there was no force
  double gap_ms = 0;      // longest time between two writes meanwhile
  double most = 0;        // N; largest force
  double step = 0;        // N; largest change between two writes of a loop in time
};

inline Fall FallAfter(const std::vector<FakeRecord::Write>& writes, std::int64_t gone_ns) {
  Fall fall;
  double before = 0;
  double held = -1;
  bool fallen = false;
  std::int64_t before_ns = 0;
  for (const FakeRecord::Write& write : writes) {
    const double force = Motor::ForceOf(write);
    fall.most = std::max(fall.most, force);
    if (before_ns != 0 && write.ns - before_ns < MotorGuard::kMostGapNs) {
      fall.step = std::max(fall.step, std::abs(force - before));
    }
    if (write.ns > gone_ns) {
      const double after_ms = 1e-6 * static_cast<double>(write.ns - gone_ns);
      if (before_ns != 0 && fall.zero_ms == 0) {
        fall.gap_ms = std::max(fall.gap_ms, 1e-6 * static_cast<double>(write.ns - before_ns));
      }
      if (held < 0) {
        held = before;
        fall.held_N = before;
      }
      held = fallen ? held : std::max(held, force);
      if (!fallen && force < held - 1e-9) {
        fallen = true;
        fall.damping_ms = after_ms;
      }
      if (force == 0 && fall.zero_ms == 0) fall.zero_ms = after_ms;
      if (force > 0) fall.zero_ms = 0;
    }
    before = force;
    before_ns = write.ns;
  }
  return fall;
}

}  // namespace tandem::testing
