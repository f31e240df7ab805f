#pragma once

#include <atomic>
#include <cstdint>

#include "engine/base/spatial.h"
#include "engine/safety/device_limits.h"

namespace tandem {

/// Carries the force of a device whose vendor's library fetches it in its own thread. The device's
/// loop puts the wrench that its MotorGuard passes. The vendor's thread takes it right before it
/// writes to the motor. That thread goes on when the loop stands still, so the mailbox is a guard
/// too. From 5 ms of age on the force falls by the slew, and from 20 ms on it is zero. It comes
/// back as the MotorGuard's does, within a tenth of a second or, after 20 ms, within a second.
///
/// The loop's thread calls Put(), the vendor's thread Take(), any thread or signal handler Cut().
/// None waits for another, allocates or reads a clock.
class VendorMailbox {
 public:
  /// `limits`: in force at the motor.
  explicit VendorMailbox(const DeviceLimits& limits = {}) noexcept;

  void Put(const Wrench& F_D_W, std::int64_t now_ns) noexcept;
  /// Returns the wrench that the motor may get.
  Wrench Take(std::int64_t now_ns) noexcept;
  /// Ends the force until the next Put(); then it comes back within a second.
  void Cut() noexcept { cuts_.fetch_add(1); }

  /// Return how often a fresh wrench was taken, and the mean and greatest age at that time. A
  /// thread that takes with a period adds at most that period, besides its lateness.
  std::uint64_t taken() const noexcept { return taken_.load(std::memory_order_relaxed); }
  std::int64_t mean_age_ns() const noexcept;
  std::int64_t most_age_ns() const noexcept { return most_age_ns_.load(std::memory_order_relaxed); }

 private:
  /// Numbers that one thread writes and another reads, newest first; the reader rejects torn
  /// values.
  struct Slot {
    std::atomic<std::uint64_t> turn{0};  // odd while it is written
    std::atomic<std::int64_t> ns{0};
    std::atomic<double> wrench[6]{};
  };
  /// Reads the newest wrench, as far as it can be read now.
  void TakeNewest() noexcept;
  void SeeFresh(std::int64_t now_ns) noexcept;

  DeviceLimits limits_;
  Slot slot_;
  std::atomic<std::uint32_t> cuts_{0};

  // the vendor's thread alone
  std::uint64_t turn_ = 0;  // turn of the last wrench taken
  std::uint32_t cuts_seen_ = 0;
  Wrench newest_;
  std::int64_t put_ns_ = -1;
  std::int64_t last_ns_ = -1;
  Wrench given_;
  bool old_ = false;  // older than 5 ms when last taken
  bool none_ = true;  // no force until a fresh wrench comes
  std::int64_t ramp_begin_ns_ = 0;
  std::int64_t short_begin_ns_ = 0;
  std::int64_t ramped_ns_ = 0;

  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::int64_t> sum_age_ns_{0};
  std::atomic<std::int64_t> most_age_ns_{0};
};

}  // namespace tandem
