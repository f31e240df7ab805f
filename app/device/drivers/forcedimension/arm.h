#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "app/device/drivers/forcedimension/dhd.h"
#include "app/device/drivers/handle_sample.h"
#include "app/device/drivers/trouble.h"
#include "app/device/tandem_device.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/realtime/seqlock.h"

namespace tandem::driver {

/// A haptic arm of Force Dimension. Its library has no thread, and each call talks over USB. So a
/// thread of the driver calls it 2000 times a second, and asks for the force right before it writes
/// it. The device's own watchdog is set to 20 ms: the motors are off where the process dies or a
/// call hangs.
class Arm {
 public:
  static constexpr std::int64_t kPeriodNs = 500'000;
  static constexpr std::int64_t kOldNs = 20'000'000;      // age of a sample from which the device
                                                          // is silent
  static constexpr std::int64_t kReopenNs = 500'000'000;  // time between attempts to reopen
  static constexpr std::int64_t kStatusNs = 20'000'000;   // time between looks at the status
  static constexpr unsigned char kWatchdog = 160;         // in units of 125 us

  struct Settings {
    std::string library;      // file; empty: the driver searches for it
    int index = 0;            // index among the devices that are plugged in
    bool calibrates = false;  // true: the arm may move itself to its reference
    int clutch = 0;           // button; below 0: none
    int stop = -1;            // button
  };

  Arm(const Dhd& dhd, const TandemDeviceHost& host, const Settings& settings);
  ~Arm();
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  /// Opens the device without force. Returns the fault; empty: none.
  std::string Open();
  void Capabilities(TandemDeviceCapabilities& can) const;
  /// Starts the thread. May move the arm, where that is allowed. Returns the fault; empty: none.
  std::string Start();
  std::int32_t Read(TandemDeviceState& state) noexcept;
  void Stop() noexcept { stopped_.store(true); }
  /// Allows force again, as far as the host gives it.
  void Allow() noexcept { stopped_.store(false); }
  std::string Trouble() const;

 private:
  /// Makes the arm find its reference by itself. Returns the fault; empty: none.
  std::string FindReference();
  /// Sets up the device after each opening. Returns the fault; empty: none.
  std::string Prepare();
  void Turn(std::int64_t now_ns) noexcept;
  /// Reads the handle. False: a call failed.
  bool Measure(HandleSample& sample) noexcept;
  /// Asks the host for the force and writes it. False: the call failed.
  bool WriteForce() noexcept;
  /// Handles a failed call. Returns whether the device is gone.
  bool TakeFault(std::int64_t now_ns) noexcept;
  /// Opens a device that is back.
  void Reopen(std::int64_t now_ns) noexcept;
  /// Checks why the device gives no force; TANDEM_OK: it gives force.
  std::int32_t ReadStatus() noexcept;
  void Lose(const char* why) noexcept;
  void Close() noexcept;

  Dhd dhd_;
  const TandemDeviceHost* host_;
  Settings settings_;
  char id_ = -1;
  bool prepared_ = false;
  bool has_wrist_ = false;
  bool drives_wrist_ = false;
  double most_force_ = 0;   // N
  double most_moment_ = 0;  // N m
  std::unique_ptr<PeriodicThread> thread_;
  Seqlock<HandleSample> sample_;
  driver::Trouble trouble_;
  std::atomic<bool> stopped_{false};
  std::int64_t read_ns_ = 0;  // time of the newest sample that Read() returned

  // used by the thread alone, once it runs
  std::int32_t status_ = TANDEM_FAILED;
  std::int64_t status_ns_ = 0;
  double speed_ = 0;                   // m/s; newest known speed
  std::int64_t failing_since_ns_ = 0;  // 0: calls succeed
  bool lost_ = false;
  std::int64_t reopen_ns_ = 0;
};

}  // namespace tandem::driver
