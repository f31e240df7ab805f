#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "app/process/child_processes.h"
#include "engine/haptics/device_memory.h"
#include "engine/realtime/shared_memory.h"

namespace tandem {

/// A `tandem-device` that this process started, and the memory that both share.
class DeviceProcess {
 public:
  struct Options {
    std::string driver;                  // NAME[:OPTIONS]
    Pose home_W{};                       // pose of the body that the hand is to hold
    DeviceLimits users = kUsersDefault;  // limits that the user set
    int core = -1;
    bool passivity_control = false;  // damp a port that gives out more energy than it took
  };
  /// Starts the process and returns when the device has begun. Errors: the driver's own words, a
  /// process that ended, or a device that did not open in time.
  static Result<std::unique_ptr<DeviceProcess>> Start(const Options& options);

  /// Returns the device for the haptic thread. It must not outlive this object.
  std::unique_ptr<Device> MakeDevice();
  /// Returns the time of a deadline of the device's ticks. Frames that share these deadlines find
  /// the handle of the same moment.
  std::int64_t origin_ns() const noexcept { return memory_->origin_ns; }
  DeviceCapabilities capabilities() const noexcept { return AsCapabilities(memory_->capabilities); }
  /// Returns the limits in force at the motor.
  DeviceLimits limits() const noexcept { return {memory_->limits[0], memory_->limits[1]}; }
  /// Returns the newest tick of the device; nothing before the first one.
  std::optional<DeviceTick> Newest() const noexcept;
  DeviceTimes times() const noexcept;
  /// These describe the thread of the device's loop: its scheduler, "SCHED_FIFO" or "SCHED_OTHER",
  /// and in a line what the system did not grant. An empty line: it granted all.
  std::string scheduler() const { return memory_->scheduler.data(); }
  std::string warning() const { return memory_->warning.data(); }
  /// Returns the descriptor of the shared memory, for another process that is to be the controller.
  int descriptor() const noexcept { return shared_.descriptor(); }
  std::int64_t period_ns() const noexcept { return memory_->period_ns; }
  /// Returns in a line what a person must know since the last call; empty: nothing. Control thread.
  std::string News();
  /// Asks the process to end and waits. The process ends once its motor has no force. One that does
  /// not end in time, or hangs, is killed.
  void End();
  pid_t pid() const noexcept { return process_.pid(); }

 private:
  DeviceProcess(SharedMemory shared, ChildProcess process);
  /// Returns a line when the process begins or ends to be silent: stopped, hung or starved.
  std::string Silence(std::int64_t now_ns);

  SharedMemory shared_;
  DeviceMemory* memory_;
  ChildProcess process_;
  bool end_told_ = false;
  bool silent_ = false;
  std::string trouble_told_;
  SafetyState reported_ = SafetyState::kOff;
};

}  // namespace tandem
