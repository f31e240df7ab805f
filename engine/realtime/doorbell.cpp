#include "engine/realtime/doorbell.h"

#include <climits>
#include <ctime>

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == 4 &&
              std::atomic<std::uint32_t>::is_always_lock_free);  // as the kernel requires

void Pause() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

void Doorbell::Ring() noexcept {
  rings_.fetch_add(1, std::memory_order_seq_cst);
  if (waits_.load(std::memory_order_seq_cst) == 0) return;
  syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&rings_), FUTEX_WAKE, INT_MAX, nullptr,
          nullptr, 0);
}

bool Doorbell::WaitBeyond(std::uint32_t seen, std::int64_t until_ns,
                          std::int64_t spin_ns) noexcept {
  const std::int64_t begun_ns = MonotonicNowNs();
  const std::int64_t spin_until_ns = begun_ns + spin_ns < until_ns ? begun_ns + spin_ns : until_ns;
  while (rings() == seen && MonotonicNowNs() < spin_until_ns) Pause();
  timespec until{};
  until.tv_sec = static_cast<time_t>(until_ns / kSecondNs);
  until.tv_nsec = static_cast<long>(until_ns % kSecondNs);
  waits_.store(1, std::memory_order_seq_cst);
  while (rings_.load(std::memory_order_seq_cst) == seen && MonotonicNowNs() < until_ns) {
    syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&rings_), FUTEX_WAIT_BITSET, seen, &until,
            nullptr, FUTEX_BITSET_MATCH_ANY);
  }
  waits_.store(0, std::memory_order_seq_cst);
  return rings() != seen;
}

bool Doorbell::WaitFor(std::uint32_t seen, std::int64_t wait_ns, std::int64_t spin_ns) noexcept {
  return WaitBeyond(seen, MonotonicNowNs() + wait_ns, spin_ns);
}

}  // namespace tandem
