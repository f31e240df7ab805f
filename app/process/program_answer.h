#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "app/process/child_processes.h"

namespace tandem {

/// Runs a program of this installation, and reads its answer once it has ended. The program writes
/// the answer to a descriptor, whose number follows the option `to`.
class ProgramAnswer {
 public:
  ProgramAnswer(const std::string& program, const std::vector<std::string>& words,
                const std::string& to);
  ~ProgramAnswer();
  ProgramAnswer(const ProgramAnswer&) = delete;
  ProgramAnswer& operator=(const ProgramAnswer&) = delete;

  /// Returns the exit code; nothing: the process did not start, or took longer and was ended.
  std::optional<int> Wait(std::chrono::milliseconds timeout);
  std::string text() const;

 private:
  int descriptor_;
  std::optional<ChildProcess> process_;
};

}  // namespace tandem
