#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "app/device/fake_record.h"
#include "engine/base/result.h"
#include "engine/haptics/device.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/safety/vendor_mailbox.h"

namespace tandem {

/// A device for tests and benches: keeps what its motor got, and misbehaves where it is asked to.
/// Its handle goes to a place beside its home within half a second of Start(), and may swing there.
/// Options are KEY=VALUE, with commas between; ticks count from Start():
///
/// | key | |
/// |---|---|
/// | record | file of a FakeRecord |
/// | x_mm, y_mm, z_mm | where the handle goes, from home |
/// | swing_mm, swing_hz | how it swings about that place, along x |
/// | peak_N, peak_Nm, continuous_N, continuous_Nm | what it says it can |
/// | stiffness | N/m that it says it bears |
/// | nan_at, fail_at, stop_at, jump_at | tick from which its pose is no number for one tick, it is in
/// trouble for 50, its stop button is pressed for 50, its handle stands 50 mm aside |
/// | clutch_at | tick from which its clutch button is pressed for 50 |
/// | hang_at, hang_ms | tick in which Read() takes so long |
/// | crash_at, recurse_at | tick in which it crashes, in which it runs out of its stack |
/// | open_hang_ms | how long it takes to open |
/// | rate_hz | of its own loop |
/// | vendor | not 0: a thread of its own asks for the force, rate_hz times a second |
class FakeDriver : public Device {
 public:
  static Result<std::unique_ptr<Device>> Make(const std::string& options, const Pose& X_WD0);
  ~FakeDriver() override;

  void Start() noexcept override { started_ = true; }
  Anchor Read() noexcept override;
  void Render(const Wrench& F_D_W) noexcept override;
  void Stop() noexcept override;
  AskedTimes asked_times() const noexcept override {
    if (!mailbox_) return {};
    return {mailbox_->taken(), mailbox_->mean_age_ns(), mailbox_->most_age_ns()};
  }
  DeviceCapabilities capabilities() const noexcept override { return can_; }
  bool failed() const noexcept override { return Within(fail_at_, 50); }
  bool stop_button() const noexcept override { return Within(stop_at_, 50); }
  bool clutch_button() const noexcept override { return Within(clutch_at_, 50); }

 private:
  explicit FakeDriver(const Pose& X_WD0) : X_WD0_(X_WD0) {}
  bool Within(double from, double length) const noexcept {
    return from > 0 && static_cast<double>(tick_) >= from &&
           static_cast<double>(tick_) < from + length;
  }

  /// The motor's.
  void Write(const Wrench& F_D_W) noexcept;

  Pose X_WD0_;
  DeviceCapabilities can_;
  std::unique_ptr<VendorMailbox> mailbox_;  // null: no thread asks
  std::unique_ptr<PeriodicThread> vendor_;  // null: none
  FakeRecord* record_ = nullptr;
  Vec3 aside_ = Vec3::Zero();  // m
  double swing_ = 0;           // m
  double swing_hz_ = 1;
  double nan_at_ = 0, fail_at_ = 0, stop_at_ = 0, jump_at_ = 0, hang_at_ = 0, crash_at_ = 0,
         clutch_at_ = 0, recurse_at_ = 0;
  double hang_ms_ = 30;
  bool started_ = false;
  std::int64_t tick_ = 0;
};

}  // namespace tandem
