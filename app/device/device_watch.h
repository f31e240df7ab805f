#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include <sys/types.h>

#include "engine/haptics/device.h"

namespace tandem {

/// Guards the process of a device from outside its loop, against signals, the controller's end and
/// a driver that hangs. A process has one.
///
/// | event | action |
/// |---|---|
/// | a terminal's signal (INT, QUIT, TSTP, ...) or PIPE | none: the controller answers it |
/// | the controller has ended | the loop ends once the motor has no force |
/// | any other signal that would end a process | the same |
/// | a fault of the code (SEGV, BUS, FPE, ILL, ABRT, SYS, TRAP) | zero force, then the end |
/// | no tick of the loop for 20 ms | zero force; if the process is to end, it ends |
///
/// While a driver opens, there is no loop, and the controller's end or such a signal ends the
/// process at once.
class DeviceWatch {
 public:
  static constexpr std::int64_t kLookNs = 5'000'000;     // time between two looks
  static constexpr std::int64_t kStandsNs = 20'000'000;  // time without a tick from which the loop
                                                         // counts as standing still
  static constexpr std::int64_t kForgetNs = 300'000'000;

  /// Begins before a driver is opened. `priority`: above the loop's; the thread hardly works.
  DeviceWatch(pid_t controller, int priority);
  ~DeviceWatch();
  DeviceWatch(const DeviceWatch&) = delete;
  DeviceWatch& operator=(const DeviceWatch&) = delete;

  /// Starts to guard a driver that has opened. The driver must live until Forget().
  void Guard(Device& driver) noexcept;
  /// Stops to use the driver. Ends the process if the driver blocks the watch for more than
  /// kForgetNs.
  void Forget() noexcept;

  /// Called first in the thread of the loop. Gives it a signal stack, and unblocks its signals,
  /// which other programs on the machine do not delay there.
  void EnterLoop() noexcept;
  /// Begins a tick. False: the process is about to die, and the loop must write nothing.
  bool BeginTick() noexcept;
  void EndTick() noexcept;
  /// Returns whether the process is to end. Any thread.
  bool ending() const noexcept;

 private:
  void Look(pid_t controller, int priority) noexcept;

  std::atomic<bool> over_{false};
  std::thread thread_;
};

}  // namespace tandem
