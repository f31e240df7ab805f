#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "app/device/driver_library.h"
#include "engine/base/spatial.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/histogram.h"
#include "tests/support/allocation_counter.h"

namespace tandem::testing {

/// Uses a driver of the build tree as tandem-device does, in the test's own process. Ticks come a
/// thousand times a second. It times read() and write(), counts what they allocate, and prints
/// both.
class DriverTrial {
 public:
  explicit DriverTrial(const std::string& name) {
    const Result<const TandemDriver*> loaded =
        DriverLibrary::Load(std::filesystem::path(TANDEM_DRIVER_FOLDER) / (name + ".so"));
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().what);
    if (!loaded) return;
    driver_ = *loaded;
    host_.struct_size = sizeof host_;
    host_.abi_minor = TANDEM_DEVICE_ABI_MINOR;
    host_.context = this;
    host_.say = [](void* context, const char* line) {
      static_cast<DriverTrial*>(context)->output_.emplace_back(line);
    };
    host_.take = [](void* context, TandemDeviceForce* force) {
      auto& trial = *static_cast<DriverTrial*>(context);
      if (trial.take_) trial.take_(*force);
    };
    host_.now_ns = [] {
      return MonotonicNowNs();
    };
    EXPECT_EQ(driver_->init(&host_), TANDEM_OK);
  }
  ~DriverTrial() {
    Close();
    if (driver_ != nullptr) driver_->deinit();
  }
  DriverTrial(const DriverTrial&) = delete;
  DriverTrial& operator=(const DriverTrial&) = delete;

  /// Returns what list() says, at most 16 devices.
  std::vector<TandemDeviceFound> List() const {
    std::vector<TandemDeviceFound> found(16);
    for (TandemDeviceFound& one : found) one.struct_size = sizeof one;
    const std::int32_t count = driver_->list(found.data(), 16);
    found.resize(static_cast<std::size_t>(std::max(0, count)));
    return found;
  }
  /// Opens the device. error() then has the driver's refusal.
  std::int32_t Open(const std::string& options, const Vec3& home = Vec3::Zero()) {
    TandemDeviceOpen how{};
    how.struct_size = sizeof how;
    how.options = options.c_str();
    for (int i = 0; i < 3; ++i) how.home_position[i] = home[i];
    how.home_orientation[3] = 1;
    return driver_->open(&how, &device_);
  }
  TandemDeviceCapabilities Capabilities() const {
    TandemDeviceCapabilities can{};
    can.struct_size = sizeof can;
    EXPECT_EQ(driver_->capabilities(device_, &can), TANDEM_OK);
    return can;
  }
  std::int32_t Start() { return driver_->start(device_); }

  /// Does one read and one write of `force`, timed, and counts what they allocate.
  std::int32_t Tick(const Vec3& force_N = Vec3::Zero(), const Vec3& moment_Nm = Vec3::Zero()) {
    TandemDeviceState next{};
    next.struct_size = sizeof next;
    TandemDeviceForce force{};
    force.struct_size = sizeof force;
    force.begun = 1;
    for (int i = 0; i < 3; ++i) {
      force.force[i] = force_N[i];
      force.moment[i] = moment_Nm[i];
    }
    const std::int64_t begun_ns = MonotonicNowNs();
    std::int64_t read_ns = 0;
    {
      const AllocationCounter counter;
      read_ = driver_->read(device_, &next);
      read_ns = MonotonicNowNs();
      written_ = driver_->write(device_, &force);
      allocations_ += counter.count();
    }
    reads_.Add(read_ns - begun_ns);
    writes_.Add(MonotonicNowNs() - read_ns);
    if (read_ == TANDEM_OK) state_ = next;
    return read_;
  }
  /// Does so many ticks, a millisecond apart.
  void Ticks(int count, const Vec3& force_N = Vec3::Zero(), const Vec3& moment_Nm = Vec3::Zero()) {
    auto due = std::chrono::steady_clock::now();
    for (int i = 0; i < count; ++i) {
      Tick(force_N, moment_Nm);
      due += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(due);
    }
  }
  /// Ticks until that is so, for so many milliseconds at the most.
  bool TicksUntil(const std::function<bool()>& is_so, int most = 3000) {
    for (int i = 0; i < most; ++i) {
      if (is_so()) return true;
      Ticks(1);
    }
    return is_so();
  }
  void Stop() { driver_->stop(device_); }
  void Close() {
    if (device_ != nullptr) driver_->close(device_);
    device_ = nullptr;
  }
  std::string Error() const {
    char text[512] = "";
    driver_->last_error(device_, text, sizeof text);
    return text;
  }

  const TandemDriver& driver() const { return *driver_; }
  TandemDevice* device() const { return device_; }
  const TandemDeviceState& state() const { return state_; }  // newest that had news
  Vec3 position() const { return Vec3(state_.position); }
  std::int32_t read() const { return read_; }
  std::int32_t written() const { return written_; }
  const std::vector<std::string>& output() const { return output_; }
  long allocations() const { return allocations_; }
  /// Sets a function that is called with the force that a vendor's thread gets, on that thread.
  void SetTake(std::function<void(TandemDeviceForce&)> take) { take_ = std::move(take); }

  /// Records the times, and expects that no tick allocated.
  void ExpectRealtime() const {
    const auto record = [](const char* key, std::int64_t value) {
      ::testing::Test::RecordProperty(key, std::to_string(value));
    };
    record("ticks", static_cast<std::int64_t>(reads_.count()));
    record("read_p99_ns", static_cast<std::int64_t>(reads_.Quantile(0.99)));
    record("write_p99_ns", static_cast<std::int64_t>(writes_.Quantile(0.99)));
    EXPECT_EQ(allocations_, 0);
  }

 private:
  const TandemDriver* driver_ = nullptr;
  TandemDeviceHost host_{};
  TandemDevice* device_ = nullptr;
  TandemDeviceState state_{};
  std::int32_t read_ = TANDEM_OK;
  std::int32_t written_ = TANDEM_OK;
  Histogram reads_, writes_;
  long allocations_ = 0;
  std::vector<std::string> output_;
  std::function<void(TandemDeviceForce&)> take_;
};

}  // namespace tandem::testing
