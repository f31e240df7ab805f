#include "app/device/device_watch.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "app/common/exit_codes.h"

namespace tandem {
namespace {

/// A device whose driver takes long to stop the motors.
class SlowToStop : public Device {
 public:
  explicit SlowToStop(std::chrono::milliseconds takes) : takes_(takes) {}
  void Start() noexcept override {}
  Anchor Read() noexcept override { return {}; }
  void Render(const Wrench&) noexcept override {}
  void Stop() noexcept override {
    stopping.store(true);
    std::this_thread::sleep_for(takes_);
    stopping.store(false);
  }

  std::atomic<bool> stopping{false};

 private:
  const std::chrono::milliseconds takes_;
};

/// Ends the program while the watch stops the motor of a loop that stands still. Exit code 0 says
/// that nobody was in the driver any more. The watch takes over a process's signals, so each run
/// has a process of its own.
[[noreturn]] void EndWhileTheWatchStops(std::chrono::milliseconds takes) {
  SlowToStop device(takes);
  DeviceWatch watch(getppid(), 0);
  watch.Guard(device);
  while (!device.stopping.load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  watch.Forget();
  _exit(device.stopping.load() ? 1 : 0);
}

// The watch must not be in the driver when the driver is destroyed.
TEST(DeviceWatchDeathTest, ForgetsTheDriverOnlyAfterLeavingIt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(EndWhileTheWatchStops(std::chrono::milliseconds(100)), ::testing::ExitedWithCode(0),
              "");
}

TEST(DeviceWatchDeathTest, EndsTheProcessOfAHungDriver) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(EndWhileTheWatchStops(std::chrono::hours(1)), ::testing::ExitedWithCode(kExitDevice),
              "");
}

}  // namespace
}  // namespace tandem
