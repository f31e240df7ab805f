#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "app/device/drivers/openhaptics/hd.h"
#include "app/device/drivers/trouble.h"
#include "app/device/tandem_device.h"
#include "engine/realtime/seqlock.h"

namespace tandem::driver {

/// A Touch or Phantom. The vendor's scheduler calls back a thousand times a second: there the
/// handle is read, and the force is asked for and written, within one frame of the library. A
/// thread of the driver's own opens the device anew where it was unplugged.
class Stylus {
 public:
  static constexpr std::int64_t kOldNs = 20'000'000;  // of a sample: the scheduler stands still
  static constexpr int kLookMs = 20;                  // between two looks of the keeper
  static constexpr int kReopenMs = 500;
  static constexpr int kCalibrationEvery = 50;  // ticks
  static constexpr int kFailedTicks = 100;      // that a force error is told for
  static constexpr int kRampTicks = 200;        // in which force comes back
  // warm motors: the force shrinks a little each tick above the one, and grows again below the
  // other
  static constexpr double kWarm = 0.7;
  static constexpr double kCool = 0.5;
  static constexpr double kShrink = 0.999;
  static constexpr double kGrow = 1.001;

  struct Settings {
    std::string device;       // the name that the vendor's setup gave; empty: the usual ones
    bool calibrates = false;  // resets the encoders when it opens: the stylus lies in its inkwell
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

  /// Whether a device has what not all have; known after the first frame.
  enum class Has : std::uint8_t { kUnknown, kYes, kNot };

  std::string Init();
  std::string BeginScheduler(bool is_first);
  void EndScheduler() noexcept;
  /// The scheduler's call.
  void Tick() noexcept;
  /// Gets what a device need not have; false: it has not. `code` becomes what the library says of
  /// other calls, if that is worse.
  bool Get(unsigned what, double* values, Has& has, unsigned& code) noexcept;
  /// Looks whether the library knows where the handle is.
  std::int32_t CheckCalibration() noexcept;
  void WriteForce(unsigned& code) noexcept;
  /// Takes the worst that the library said in a frame.
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
  Seqlock<Sample> sample_;
  driver::Trouble trouble_;
  std::int64_t read_ns_ = 0;  // of the newest sample that Read() gave

  // the scheduler's own
  std::int32_t calibration_ = TANDEM_OK;
  int ticks_ = 0;
  int failed_ticks_ = 0;  // that are still to be told
  double share_ = 1;      // of the force, for warm motors
  double ramp_ = 0;       // of the force, after there was none
  unsigned update_ = 0;   // style of a calibration that is due
  std::int64_t last_ns_ = 0;
  Has has_temperature_ = Has::kUnknown;
  Has has_velocity_ = Has::kUnknown;
  Has has_turn_ = Has::kUnknown;  // angular velocity
};

}  // namespace tandem::driver
