#include "tests/network/hostile/stopped_thread.h"

#include <sys/ptrace.h>
#include <sys/wait.h>

#include "tests/network/syscall_count.h"

namespace tandem::testing {

StoppedThread::StoppedThread(pid_t process, const std::string& name)
    : thread_(AwaitThread(process, name).value_or(0)) {
  if (thread_ == 0 || ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) != 0) return;
  if (ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr) != 0) return;
  int status = 0;
  stopped_ = waitpid(thread_, &status, __WALL) == thread_ && WIFSTOPPED(status);
}

StoppedThread::~StoppedThread() {
  if (stopped_) ptrace(PTRACE_DETACH, thread_, nullptr, nullptr);
}

}  // namespace tandem::testing
