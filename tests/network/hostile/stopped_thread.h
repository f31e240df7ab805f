#pragma once

#include <string>

#include <sys/types.h>

namespace tandem::testing {

/// Stops one thread of a child process with ptrace, from construction to destruction, both by one
/// thread of the test. The others go on.
class StoppedThread {
 public:
  /// The thread is the one of that name (the first 15 characters).
  StoppedThread(pid_t process, const std::string& name);
  ~StoppedThread();
  StoppedThread(const StoppedThread&) = delete;
  StoppedThread& operator=(const StoppedThread&) = delete;

  /// Returns false where there is no such thread, or ptrace is refused.
  bool stopped() const { return stopped_; }

 private:
  pid_t thread_ = 0;
  bool stopped_ = false;
};

}  // namespace tandem::testing
