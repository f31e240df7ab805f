#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "app/device/drivers/handle_sample.h"
#include "app/device/drivers/openhaptics/hd.h"
#include "app/device/drivers/trouble.h"
#include "app/device/tandem_device.h"
#include "engine/realtime/seqlock.h"

namespace tandem::driver {

/// A Touch or Phantom. The vendor's scheduler calls back a thousand times a second. Within one
/// frame of the library, the call reads the handle, asks for the force and writes it. A thread of
/// the driver opens the device again after it was unplugged.
class Stylus {
 public:
  static constexpr std::int64_t kOldNs = 20'000'000;  // age of a sample from which the scheduler
                                                      // stands still
  static constexpr int kLookMs = 20;                  // time between two looks of the keeper
  static constexpr int kReopenMs = 500;
  static constexpr int kCalibrationEvery = 50;  // ticks
  static constexpr int kFailedTicks = 100;      // ticks for which a force error is reported
  static constexpr int kRampTicks = 200;        // ticks in which force comes back
  // warm motors: each tick the force shrinks a little above kWarm, and grows again below kCool
  static constexpr double kWarm = 0.7;
  static constexpr double kCool = 0.5;
  static constexpr double kShrink = 0.999;
  static constexpr double kGrow = 1.001;

  struct Settings {
    std::string device;       // name given by the vendor's setup; empty: the usual ones
    bool calibrates = false;  // true: resets the encoders when it opens; the stylus must lie in
                              // its inkwell
    int clutch = 0;           // button; below 0: none
    int stop = -1;
  };

  Stylus(const Hd& hd, const TandemDeviceHost& host, const Settings& settings);
  ~Stylus();
  Stylus(const Stylus&) = delete;
  Stylus& operator=(const Stylus&) = delete;

  /// Opens the device without force. Returns the fault; empty: none.
  std::string Open();
  void Capabilities(TandemDeviceCapabilities& can) const { can = can_; }
  std::string Start();
  std::int32_t Read(TandemDeviceState& state) noexcept;
  void Stop() noexcept { stopped_.store(true); }
  void Allow() noexcept { stopped_.store(false); }
  std::string Trouble() const;

 private:
  /// Says if a device has an optional quantity. It is known after the first frame.
  enum class Has : std::uint8_t { kUnknown, kYes, kNot };

  std::string Init();
  std::string BeginScheduler(bool is_first);
  void EndScheduler() noexcept;
  /// Does the work of a tick, called by the scheduler.
  void Tick() noexcept;
  /// Reads an optional quantity. False: the device does not have it. `code` becomes the worst error
  /// of all calls of the tick so far.
  bool Get(unsigned what, double* values, Has& has, unsigned& code) noexcept;
  /// Checks whether the library knows where the handle is.
  std::int32_t CheckCalibration() noexcept;
  void WriteForce(unsigned& code) noexcept;
  /// Takes the worst error of a frame.
  void TakeFault(unsigned code) noexcept;
  void Keep();

  Hd hd_;
  const TandemDeviceHost* host_;
  Settings settings_;
  HdHandle device_ = kHdNoDevice;
  unsigned long scheduled_ = 0;
  bool is_scheduled_ = false;
  int output_dof_ = 3;
  int style_ = 0;
  TandemDeviceCapabilities can_{};
  std::thread keeper_;
  std::atomic<bool> over_{false};
  std::atomic<bool> lost_{false};
  std::atomic<bool> broken_{false};
  std::atomic<bool> stopped_{false};
  Seqlock<HandleSample> sample_;
  driver::Trouble trouble_;
  std::int64_t read_ns_ = 0;  // time of the newest sample that Read() returned

  // used by the scheduler's thread alone
  std::int32_t calibration_ = TANDEM_OK;
  int ticks_ = 0;
  int failed_ticks_ = 0;  // ticks for which the error is still reported
  double share_ = 1;      // share of the force, for warm motors
  double ramp_ = 0;       // share of the force, while it comes back
  unsigned update_ = 0;   // style of a calibration that is due
  std::int64_t last_ns_ = 0;
  Has has_temperature_ = Has::kUnknown;
  Has has_velocity_ = Has::kUnknown;
  Has has_turn_ = Has::kUnknown;  // angular velocity
};

}  // namespace tandem::driver
