#include "tests/network/syscall_count.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>

namespace tandem::testing {

std::optional<pid_t> AwaitThread(pid_t process, const std::string& name) {
  const std::filesystem::path tasks = "/proc/" + std::to_string(process) + "/task";
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < deadline) {
    std::error_code gone;
    for (const auto& task : std::filesystem::directory_iterator(tasks, gone)) {
      std::string comm;
      std::getline(std::ifstream(task.path() / "comm"), comm);
      if (comm == name) return static_cast<pid_t>(std::stol(task.path().filename().string()));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return std::nullopt;
}

std::optional<SyscallCount> CountSyscalls(pid_t thread) {
  if (ptrace(PTRACE_SEIZE, thread, nullptr, PTRACE_O_TRACESYSGOOD) != 0) return std::nullopt;
  if (ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0) return std::nullopt;
  SyscallCount count;
  std::map<long, long> since_sleep;
  int status = 0;
  while (waitpid(thread, &status, __WALL) == thread && WIFSTOPPED(status)) {
    const bool at_syscall = WSTOPSIG(status) == (SIGTRAP | 0x80);
    const bool by_ptrace = (status >> 16) == PTRACE_EVENT_STOP;
    if (at_syscall) {
      __ptrace_syscall_info info{};
      ptrace(PTRACE_GET_SYSCALL_INFO, thread, sizeof info, &info);
      const auto number = static_cast<long>(info.entry.nr);
      if (info.op == PTRACE_SYSCALL_INFO_ENTRY && number == SYS_clock_nanosleep) {
        // calls before the first sleep belong to the thread's beginning, calls after the last to
        // its end
        if (count.sleeps > 0) {
          for (const auto& [call, times] : since_sleep) count.calls[call] += times;
        }
        since_sleep.clear();
        ++count.sleeps;
      } else if (info.op == PTRACE_SYSCALL_INFO_ENTRY) {
        ++since_sleep[number];
      }
    }
    const int signal = at_syscall || by_ptrace ? 0 : WSTOPSIG(status);
    if (ptrace(PTRACE_SYSCALL, thread, nullptr, signal) != 0) break;
  }
  return count;
}

}  // namespace tandem::testing
