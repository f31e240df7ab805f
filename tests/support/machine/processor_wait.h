#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include <sys/types.h>

namespace tandem::testing {

/// Measures how long a program's threads have waited for a processor that others had. A bound on
/// what the program does itself is not a bound on that. On a quiet machine it is next to nothing.
class ProcessorWait {
 public:
  explicit ProcessorWait(pid_t pid) : pid_(pid), before_s_(Sum()) {}

  /// Looks at the threads that live now. Returns the wait since the beginning, of all threads that
  /// one look has found, s.
  double Look() {
    most_s_ = std::max(most_s_, Sum() - before_s_);
    return most_s_;
  }

 private:
  double Sum() const {
    double sum_s = 0;
    std::error_code gone;
    const std::filesystem::path tasks = "/proc/" + std::to_string(pid_) + "/task";
    for (const auto& task : std::filesystem::directory_iterator(tasks, gone)) {
      std::ifstream stream(task.path() / "schedstat");
      double ran_ns = 0;
      double waited_ns = 0;
      if (stream >> ran_ns >> waited_ns) sum_s += 1e-9 * waited_ns;
    }
    return sum_s;
  }

  pid_t pid_;
  double before_s_;
  double most_s_ = 0;
};

}  // namespace tandem::testing
