#include "engine/realtime/realtime_setup.h"

#include <array>
#include <cstddef>

#include <pwd.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace tandem {
namespace {

bool EnterFifo(int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) == 0;
}

// Tells whether any amount may be locked. Capabilities alone do not decide (in a user namespace
// they do not count). So it locks one page more than the limit for a moment, without touching it.
bool MayLockWithoutLimit() noexcept {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) != 0) return false;
  if (limit.rlim_cur == RLIM_INFINITY) return true;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t size = (limit.rlim_cur / page + 1) * page;
  void* probe = mmap(nullptr, size, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (probe == MAP_FAILED) return false;
  const bool locked = mlock2(probe, size, MLOCK_ONFAULT) == 0;
  munmap(probe, size);
  return locked;
}

bool LockMemory() noexcept {
  if (!MayLockWithoutLimit()) return false;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return true;
  munlockall();
  return false;
}

[[gnu::noinline]] void PrefaultStack() noexcept {
  std::array<volatile char, kPrefaultedStack> stack;
  for (std::size_t i = 0; i < stack.size(); i += 1024) stack[i] = 0;
}

std::string LoginName() {
  std::array<char, 4096> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  getpwuid_r(geteuid(), &entry, buffer.data(), buffer.size(), &found);
  return found != nullptr ? found->pw_name : "*";
}

}  // namespace

std::string RealtimeWarning(const RealtimeStatus& status, int wanted_priority,
                            const std::string& user) {
  std::string lacking;
  std::string lines;
  if (!status.fifo) {
    lacking += "SCHED_FIFO was refused";
    lines += " '" + user + " - rtprio " + std::to_string(wanted_priority) + "'";
  }
  if (!status.memory_locked) {
    lacking += lacking.empty() ? "" : ", ";
    lacking += "memory is not locked";
    lacking += status.stack_prefaulted ? " (only the stack is in place)" : "";
    lines += " '" + user + " - memlock unlimited'";
  }
  if (!lines.empty()) {
    return "not fully real-time: " + lacking + "; to allow it: printf '%s\\n'" + lines +
           " | sudo tee /etc/security/limits.d/tandem.conf, then log in again";
  }
  return status.timer_slack ? "" : "not fully real-time: the timer slack could not be set";
}

bool KeepToCore(int core) noexcept {
  if (core < 0 || core >= CPU_SETSIZE) return false;
  cpu_set_t wanted;
  CPU_ZERO(&wanted);
  CPU_SET(core, &wanted);
  return sched_setaffinity(0, sizeof wanted, &wanted) == 0;
}

RealtimeStatus EnterRealtime(int priority) noexcept {
  RealtimeStatus status;
  status.timer_slack = prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0;
  status.fifo = EnterFifo(priority);
  status.priority = status.fifo ? priority : 0;
  status.memory_locked = LockMemory();
  PrefaultStack();
  status.stack_prefaulted = true;
  status.warning = RealtimeWarning(status, priority, LoginName());
  return status;
}

}  // namespace tandem
