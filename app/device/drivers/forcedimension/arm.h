#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "app/device/drivers/forcedimension/dhd.h"
#include "app/device/drivers/trouble.h"
#include "app/device/tandem_device.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/realtime/seqlock.h"

namespace tandem::driver {

/// A haptic arm of Force Dimension. Its library has no thread of its own, and each call talks over
/// USB: a thread of the driver's own calls it, 2000 times a second, and takes the force right
/// before it writes it. The device's own watchdog is set to 20 ms, so that the motors are off where
/// the process dies or a call hangs.
class Arm {
 public:
  static constexpr std::int64_t kPeriodNs = 500'000;
  static constexpr std::int64_t kOldNs = 20'000'000;      // of a sample: the device is silent
  static constexpr std::int64_t kReopenNs = 500'000'000;  // between tries to find it again
  static constexpr std::int64_t kStatusNs = 20'000'000;   // between looks at its status
  static constexpr unsigned char kWatchdog = 160;         // of 125 us

  struct Settings {
    std::string library;      // file; empty: looked for
    int index = 0;            // of the devices that are plugged in
    bool calibrates = false;  // the arm may move itself to its reference
    int clutch = 0;           // button; below 0: none
    int stop = -1;            // button
  };

  Arm(const Dhd& dhd, const TandemDeviceHost& host, const Settings& settings);
  ~Arm();
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  /// Opens it without force. Returns the fault; empty: none.
  std::string Open();
  void Capabilities(TandemDeviceCapabilities& can) const;
  /// May move the arm, where that is allowed. Returns the fault.
  std::string Start();
  std::int32_t Read(TandemDeviceState& state) noexcept;
  void Stop() noexcept { stopped_.store(true); }
  /// There is force again, as far as the host gives some.
  void Allow() noexcept { stopped_.store(false); }
  std::string Trouble() const;

 private:
  struct Sample {
    std::int64_t time_ns = 0;
    std::int32_t result = TANDEM_FAILED;
    std::uint32_t valid = 0;
    std::uint32_t buttons = 0;
    std::array<double, 3> p_VD{};
    std::array<double, 4> q_VD{};
    std::array<double, 3> v_VD{};
    std::array<double, 3> w_VD{};
  };

  /// Has the arm find its reference by itself; the fault.
  std::string FindReference();
  /// What has to be done each time that it was opened; the fault.
  std::string Prepare();
  void Turn(std::int64_t now_ns) noexcept;
  /// Reads the handle; false: a call failed.
  bool Measure(Sample& sample) noexcept;
  /// False: the call failed.
  bool WriteForce() noexcept;
  /// After a call that failed; true: the device is gone.
  bool TakeFault(std::int64_t now_ns) noexcept;
  /// Takes up the device that is back.
  void Reopen(std::int64_t now_ns) noexcept;
  /// Looks why it gives no force; TANDEM_OK: it does.
  std::int32_t LookAtStatus() noexcept;
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
  Seqlock<Sample> sample_;
  driver::Trouble trouble_;
  std::atomic<bool> stopped_{false};
  std::int64_t read_ns_ = 0;  // of the newest sample that read() gave

  // the thread's own
  std::int32_t status_ = TANDEM_FAILED;
  std::int64_t status_ns_ = 0;
  double speed_ = 0;                   // m/s, the newest that is known
  std::int64_t failing_since_ns_ = 0;  // 0: it is not
  bool lost_ = false;
  std::int64_t reopen_ns_ = 0;
};

}  // namespace tandem::driver
