#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "app/device/tandem_device.h"
#include "engine/base/result.h"
#include "engine/haptics/device.h"
#include "engine/safety/vendor_mailbox.h"

namespace tandem {

/// A driver's device as the device loop uses it. Maps the handle from the device's frame V to the
/// part that the hand is to hold. The handle's first pose is mapped to the part's, and the mapped
/// handle then moves as the handle does in V. After an unplugged device comes back, the mapped
/// handle goes on from its last place.
///
/// Read() and Render() are for the loop's thread, Stop() for any thread, the others for the main
/// thread.
/// Read() and Render() are for the loop's thread, Stop() for any, all else for the main thread.
class DriverDevice : public Device {
 public:
  /// Opens and starts the device that `options` name. `X_WB0`: the pose of the part that the hand
  /// is to hold. May take seconds. Errors come from the driver.
  static Result<std::unique_ptr<DriverDevice>> Open(const TandemDriver& driver,
                                                    const std::string& options, const Pose& X_WB0);
  ~DriverDevice() override;
  DriverDevice(const DriverDevice&) = delete;
  DriverDevice& operator=(const DriverDevice&) = delete;

  void Start() noexcept override { begun_ = true; }
  Anchor Read() noexcept override;
  void Render(const Wrench& F_D_W) noexcept override;
  void Stop() noexcept override;
  DeviceCapabilities capabilities() const noexcept override { return can_; }
  bool failed() const noexcept override { return failed_.load(std::memory_order_relaxed); }
  bool stop_button() const noexcept override { return (buttons_ & TANDEM_BUTTON_STOP) != 0; }
  bool clutch_button() const noexcept override { return (buttons_ & TANDEM_BUTTON_CLUTCH) != 0; }
  ForceFetchTimes fetch_times() const noexcept override;

  /// Says why the device is in trouble, in a line for a person; empty: it is not.
  std::string Trouble() const;
  /// Returns the newest result of the driver's read().
  std::int32_t newest_read() const noexcept { return newest_read_.load(std::memory_order_relaxed); }
  /// Returns the capabilities that the driver reported before the loop started.
  const TandemDeviceCapabilities& reported() const noexcept { return reported_; }

 private:
  explicit DriverDevice(const TandemDriver& driver) : driver_(&driver) {}
  Result<bool> Begin(const std::string& options, const Pose& X_WB0);
  DeviceCapabilities CapabilitiesOf(const TandemDeviceCapabilities& reported) const;
  /// Maps the handle that the driver reported.
  void Take(const TandemDeviceState& state) noexcept;
  /// Derives the speed of the mapped handle from its last poses, where the driver reports none.
  void Derive(const Pose& X_WD, std::int64_t time_ns) noexcept;

  const TandemDriver* driver_;
  TandemDeviceHost host_{};
  TandemDevice* device_ = nullptr;
  bool initialised_ = false;
  TandemDeviceCapabilities reported_{};
  DeviceCapabilities can_;
  std::unique_ptr<VendorMailbox> mailbox_;  // null: write() gives the motors their force
  Anchor handle_;                           // mapped handle
  // the reference of the mapping: the pose in V and the mapped pose at the same moment
  std::optional<Pose> X_VD0_;
  Pose X_WD0_;
  bool lost_ = false;  // the handle may have moved unseen: the mapping begins again
  std::int64_t last_ns_ = -1;
  std::uint32_t buttons_ = 0;
  bool begun_ = false;
  std::atomic<bool> failed_{false};
  std::atomic<std::int32_t> newest_read_{TANDEM_OK};
};

}  // namespace tandem
