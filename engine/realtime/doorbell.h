#pragma once

#include <atomic>
#include <cstdint>

namespace tandem {

/// Wakes one waiting thread, of this process or of another that shares the memory. Ringing never
/// waits, and costs a system call only if a thread waits.
class Doorbell {
 public:
  /// Returns how often it has rung.
  std::uint32_t rings() const noexcept { return rings_.load(std::memory_order_acquire); }
  void Ring() noexcept;
  /// Returns when it has rung since rings() was `seen`, or at `until_ns` (monotonic). Returns
  /// whether it has rung. Polls for `spin_ns` before it sleeps.
  bool WaitBeyond(std::uint32_t seen, std::int64_t until_ns, std::int64_t spin_ns) noexcept;
  /// Does the same for a time from now on.
  bool WaitFor(std::uint32_t seen, std::int64_t wait_ns, std::int64_t spin_ns) noexcept;

 private:
  std::atomic<std::uint32_t> rings_{0};
  std::atomic<std::uint32_t> waits_{0};
};

}  // namespace tandem
