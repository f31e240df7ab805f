#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/process/child_processes.h"

namespace tandem::testing {

/// A network namespace of the kernel, as a machine has one: with loopback, and links to others. It
/// takes root's rights.
class Machine {
 public:
  Machine();

  /// Returns why there is none; empty: there is.
  const std::string& why_not() const { return why_not_; }
  std::string pid() const { return std::to_string(process_->pid()); }
  /// Runs lines of shell in it. Returns whether all went well.
  bool Run(const std::string& lines) const;
  /// Returns the command that runs another one in it.
  std::vector<std::string> At(const std::vector<std::string>& command) const;
  /// Calls `work` on a thread whose sockets are this machine's.
  void Within(const std::function<void()>& work) const;

 private:
  std::string why_not_;
  std::optional<ChildProcess> process_;
};

/// Links two machines: an interface of that name in each, without addresses, down.
bool Link(const Machine& a, const std::string& name_a, const Machine& b, const std::string& name_b);

}  // namespace tandem::testing
