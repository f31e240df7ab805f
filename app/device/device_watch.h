#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include <sys/types.h>

#include "engine/haptics/device.h"

namespace tandem {

/// Looks after the process of a device from outside its loop: what a signal, the controller's end
/// or a driver that hangs does to the motor. There is one in a process.
///
/// | what happens | what it does |
/// |---|---|
/// | a signal of a terminal (INT, QUIT, TSTP, ...) or PIPE | nothing: the controller answers those |
/// | the controller has ended, or any other signal that would end a process | the loop ends once the
/// motor has no force; while a driver opens, the process ends at once |
/// | a fault of our own code (SEGV, BUS, FPE, ILL, ABRT, SYS, TRAP) | zero at the motor, and then the
/// process dies of it |
/// | the loop stands still for 20 ms | zero at the motor; if the process is to end, it does |
class DeviceWatch {
 public:
  static constexpr std::int64_t kLookNs = 5'000'000;     // between two looks
  static constexpr std::int64_t kStandsNs = 20'000'000;  // of a loop without a tick
  static constexpr std::int64_t kForgetNs = 300'000'000;

  /// Begins, before a driver is opened. `priority`: above the loop's, for it hardly works.
  DeviceWatch(pid_t controller, int priority);
  ~DeviceWatch();
  DeviceWatch(const DeviceWatch&) = delete;
  DeviceWatch& operator=(const DeviceWatch&) = delete;

  /// The driver has opened, and its ticks begin. It outlives the watch's next Forget().
  void Guard(Device& driver) noexcept;
  /// The watch uses the driver no more. Ends the process where the driver holds the watch up for
  /// longer than kForgetNs.
  void Forget() noexcept;

  /// First thing in the thread that ticks: it may run out of its own stack, and it hears signals
  /// that other programs do not hold up.
  void EnterLoop() noexcept;
  /// False: the process is about to die, and nothing is to be written any more.
  bool BeginTick() noexcept;
  void EndTick() noexcept;
  /// Whether the process is to end. Any thread.
  bool ending() const noexcept;

 private:
  void Look(pid_t controller, int priority) noexcept;

  std::atomic<bool> over_{false};
  std::thread thread_;
};

}  // namespace tandem
