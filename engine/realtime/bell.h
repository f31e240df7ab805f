#pragma once

#include <atomic>
#include <cstdint>

namespace tandem {

/// Wakes one waiting thread, of this process or of another that shares the memory. Ringing never
/// waits, and costs a call of the kernel only where somebody waits.
class Bell {
 public:
  /// How often it has rung.
  std::uint32_t rings() const noexcept { return rings_.load(std::memory_order_acquire); }
  void Ring() noexcept;
  /// Returns when it has rung since rings() was `seen`, or at `until_ns` (monotonic); whether it
  /// has. Looks for `spin_ns` without sleeping first.
  bool WaitBeyond(std::uint32_t seen, std::int64_t until_ns, std::int64_t spin_ns) noexcept;
  /// The same for a time from now on.
  bool WaitFor(std::uint32_t seen, std::int64_t wait_ns, std::int64_t spin_ns) noexcept;

 private:
  std::atomic<std::uint32_t> rings_{0};
  std::atomic<std::uint32_t> waits_{0};
};

}  // namespace tandem
