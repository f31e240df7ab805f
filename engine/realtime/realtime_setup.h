#pragma once

#include <string>

namespace tandem {

/// What the kernel granted to a thread that asked to be real-time.
struct RealtimeStatus {
  bool fifo = false;              // runs under SCHED_FIFO
  int priority = 0;               // under SCHED_FIFO; else 0
  bool timer_slack = false;       // sleeps end on time to the ns, not to the 50 us that are usual
  bool memory_locked = false;     // the whole process, now and later
  bool stack_prefaulted = false;  // this thread's stack was touched down to kPrefaultedStack bytes
  int core = -1;                  // that it keeps to; below 0: any
  std::string warning;            // for a person, one line; empty when all was granted

  /// "SCHED_FIFO" or "SCHED_OTHER".
  const char* scheduler() const noexcept { return fifo ? "SCHED_FIFO" : "SCHED_OTHER"; }
};

/// Keeps the calling thread to one processor core; false: there is no such core for us.
bool KeepToCore(int core) noexcept;

inline constexpr int kPrefaultedStack = 512 * 1024;

/// Makes the calling thread as real-time as the kernel allows: SCHED_FIFO at `priority` (1 to 99,
/// not handed on to children), timer slack of 1 ns, and the process's memory locked. Call it after
/// loading. Whatever is refused is left as it was and told in the status.
///
/// Memory is locked only where any amount may be: under a limit the call itself would succeed, and
/// later allocations fail.
RealtimeStatus EnterRealtime(int priority) noexcept;

/// What a person reads when `status` lacks something that `user` (a login name) could be granted:
/// what is lacking, and the lines of /etc/security/limits.d that grant it. Empty when nothing is.
std::string RealtimeWarning(const RealtimeStatus& status, int wanted_priority,
                            const std::string& user);

}  // namespace tandem
