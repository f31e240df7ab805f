#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/cli/child_processes.h"
#include "engine/haptics/device_memory.h"
#include "engine/realtime/shared_memory.h"

namespace tandem {

/// A `tandem-device` that we started, and the memory that we share with it.
class DeviceProcess {
 public:
  struct Options {
    std::string driver;                  // NAME[:OPTIONS]
    Pose home_W{};                       // of the body that the hand is to hold
    DeviceLimits users = kUsersDefault;  // the user's setting
    int core = -1;
    bool passivity_control = false;  // damps a port that gives out more than it took
  };
  /// Returns when the device has begun. Errors: what the driver says.
  static Result<std::unique_ptr<DeviceProcess>> Start(const Options& options);

  /// The device, for the haptic thread; must not outlive this.
  std::unique_ptr<Device> MakeDevice();
  /// Of a deadline of its ticks: frames that share them find the handle of the same moment.
  std::int64_t origin_ns() const noexcept { return memory_->origin_ns; }
  DeviceCapabilities capabilities() const noexcept { return AsCapabilities(memory_->capabilities); }
  /// In force at the motor.
  DeviceLimits limits() const noexcept { return {memory_->limits[0], memory_->limits[1]}; }
  /// What the device said last; nothing: nothing yet.
  std::optional<DeviceTick> Newest() const noexcept;
  DeviceTimes times() const noexcept;
  /// Of the thread of its loop: "SCHED_FIFO" or "SCHED_OTHER", and what it was not granted, in a
  /// line; empty: nothing.
  std::string scheduler() const { return memory_->scheduler.data(); }
  std::string warning() const { return memory_->warning.data(); }
  /// Of the shared memory, for another process that is to be the controller.
  int descriptor() const noexcept { return shared_.descriptor(); }
  std::int64_t period_ns() const noexcept { return memory_->period_ns; }
  /// What a person is to know since the last call, in a line; empty: nothing. Control thread.
  std::string News();
  /// Ends it, once its motor has no force.
  void End();
  pid_t pid() const noexcept { return process_.pid(); }

 private:
  DeviceProcess(SharedMemory shared, ChildProcess process);

  SharedMemory shared_;
  DeviceMemory* memory_;
  ChildProcess process_;
  bool end_told_ = false;
  std::string trouble_told_;
  SafetyState told_ = SafetyState::kOff;
};

}  // namespace tandem
