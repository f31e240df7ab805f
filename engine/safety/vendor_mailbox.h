#pragma once

#include <atomic>
#include <cstdint>

#include "engine/base/spatial.h"
#include "engine/safety/device_limits.h"

namespace tandem {

/// The force of a device whose vendor's library asks for it in a thread of its own. The device's
/// loop puts what its MotorGuard lets through; the vendor's thread takes it right before it writes
/// to the motor. That thread goes on when the loop stands still, so it has a guard of its own: what
/// was put falls by the slew from 5 ms of age on, and from 20 ms on there is nothing. It comes back
/// as the MotorGuard's does, within a tenth of a second or, after 20 ms, within a second.
///
/// Put() is for the loop's thread, Take() for the vendor's, Cut() for any and for signal handlers.
/// None waits for another, allocates or reads a clock.
class VendorMailbox {
 public:
  /// `limits`: in force at the motor.
  explicit VendorMailbox(const DeviceLimits& limits = {}) noexcept;

  void Put(const Wrench& F_D_W, std::int64_t now_ns) noexcept;
  /// What the motor may be given.
  Wrench Take(std::int64_t now_ns) noexcept;
  /// No force from now on, until something is put again; then within a second.
  void Cut() noexcept { cuts_.fetch_add(1); }

  /// How old what was put is when it is first taken: how often, the mean and the most. A thread that
  /// asks with a period makes that its period at the most, beside its lateness.
  std::uint64_t taken() const noexcept { return taken_.load(std::memory_order_relaxed); }
  std::int64_t mean_age_ns() const noexcept;
  std::int64_t most_age_ns() const noexcept { return most_age_ns_.load(std::memory_order_relaxed); }

 private:
  /// Numbers that one thread writes and another reads, newest first; torn values are not taken.
  struct Slot {
    std::atomic<std::uint64_t> turn{0};  // odd while it is written
    std::atomic<std::int64_t> ns{0};
    std::atomic<double> wrench[6]{};
  };
  /// The newest, as far as it can be read now.
  void Look() noexcept;
  void SeeFresh(std::int64_t now_ns) noexcept;

  DeviceLimits limits_;
  Slot slot_;
  std::atomic<std::uint32_t> cuts_{0};

  // the vendor's thread alone
  std::uint64_t turn_ = 0;  // of what was taken last
  std::uint32_t cuts_seen_ = 0;
  Wrench newest_;
  std::int64_t put_ns_ = -1;
  std::int64_t last_ns_ = -1;
  Wrench given_;
  bool old_ = false;   // older than 5 ms when last taken
  bool none_ = true;   // nothing, until something fresh comes
  std::int64_t ramp_begin_ns_ = 0;
  std::int64_t short_begin_ns_ = 0;
  std::int64_t ramped_ns_ = 0;

  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::int64_t> sum_age_ns_{0};
  std::atomic<std::int64_t> most_age_ns_{0};
};

}  // namespace tandem
