#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sched.h>
#include <sys/types.h>

#include "app/common/program_folders.h"
#include "app/common/stop_signal.h"
#include "engine/base/result.h"

namespace tandem {

/// A program that this process started. The destructor ends it if it still runs, by SIGTERM and
/// then SIGKILL.
class ChildProcess {
 public:
  /// Starts a program by fork and exec. Its stdout goes to our stderr, because our stdout is one
  /// JSON document. `keep`: a file descriptor that the program gets under the same number; below 0:
  /// none.
  static Result<ChildProcess> Start(const std::vector<std::string>& command, int keep = -1);

  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();

  pid_t pid() const noexcept { return pid_; }
  /// Returns the exit code of a program that has ended, 128 + n if signal n ended it; nothing while
  /// it runs.
  std::optional<int> Poll();
  /// Waits until it ends or `timeout` has passed.
  std::optional<int> Wait(std::chrono::milliseconds timeout);
  void Signal(int signal) const noexcept;

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}

  pid_t pid_ = -1;
  std::optional<int> ended_;
};

/// Makes programs that are started during its life run on one half of the cores. Two groups of
/// programs then run as on two machines. With fewer than four cores, programs run on all.
class HalfOfTheCores {
 public:
  enum class Half { kFirst, kSecond };
  explicit HalfOfTheCores(Half half);
  ~HalfOfTheCores();
  HalfOfTheCores(const HalfOfTheCores&) = delete;
  HalfOfTheCores& operator=(const HalfOfTheCores&) = delete;

 private:
  cpu_set_t before_{};
};

/// A new folder under the system's temporary one. It is removed with its content however this
/// program ends: a small process waits for that end. If no folder can be made, the program says so
/// in a line and ends with kExitFile.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void StartGuardian();

  std::filesystem::path path_;
  pid_t guardian_ = -1;
  int lifeline_ = -1;  // the guardian sees it closed when this program has ended
  std::optional<AtForcedEnd> removal_;
};

}  // namespace tandem
