#pragma once

#include <map>
#include <optional>
#include <string>

#include <sys/types.h>

namespace tandem::testing {

/// Returns the thread of that name in a process (the first 15 characters), once there is one;
/// nothing when the process ends or 20 s pass first.
std::optional<pid_t> AwaitThread(pid_t process, const std::string& name);

/// System calls of a thread by their number, from its first sleep to its last.
struct SyscallCount {
  std::map<long, long> calls;
  long sleeps = 0;  // clock_nanosleep: one a frame

  long of(long number) const {
    const auto it = calls.find(number);
    return it == calls.end() ? 0 : it->second;
  }
};

/// Follows a thread of another process with ptrace until it ends; nothing where that is refused.
std::optional<SyscallCount> CountSyscalls(pid_t thread);

}  // namespace tandem::testing
