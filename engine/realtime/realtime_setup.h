#pragma once

#include <string>

namespace tandem {

/// The real-time properties that the kernel granted to a thread.
struct RealtimeStatus {
  bool fifo = false;              // runs under SCHED_FIFO
  int priority = 0;               // under SCHED_FIFO; else 0
  bool timer_slack = false;       // sleeps end on time to the ns, not to the usual 50 us
  bool memory_locked = false;     // the whole process's memory, now and later
  bool stack_prefaulted = false;  // this thread's stack was touched down to kPrefaultedStack bytes
  int core = -1;                  // core that the thread stays on; below 0: any
  std::string warning;            // for a person, one line; empty when all was granted

  /// Returns "SCHED_FIFO" or "SCHED_OTHER".
  const char* scheduler() const noexcept { return fifo ? "SCHED_FIFO" : "SCHED_OTHER"; }
};

/// Keeps the calling thread on one processor core; returns false if this process has no such core.
bool KeepToCore(int core) noexcept;

inline constexpr int kPrefaultedStack = 512 * 1024;

/// Makes the calling thread as real-time as the kernel allows. It sets SCHED_FIFO at `priority` (1
/// to 99, not inherited by children) and a timer slack of 1 ns, and locks the process's memory.
/// Call it after loading. A property that the kernel refuses stays as it was, and the status says
/// so.
///
/// Memory is locked only where the amount is unlimited: under a limit the call itself would
/// succeed, and later allocations would fail.
RealtimeStatus EnterRealtime(int priority) noexcept;

/// Returns a text for a person if `status` lacks a property that `user` (a login name) could be
/// granted: the missing properties, and the lines of /etc/security/limits.d that grant them. Empty
/// when nothing is missing.
std::string RealtimeWarning(const RealtimeStatus& status, int wanted_priority,
                            const std::string& user);

}  // namespace tandem
