#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/process/child_processes.h"

namespace tandem {

/// Keeps the relay and the viewers of a session, each a process. They stay until End().
class ViewerProcesses {
 public:
  /// Starts a relay and `count` viewers; nothing if `count` is 0.
  static Result<ViewerProcesses> Launch(const std::string& session, std::size_t count);

  /// Ends the viewers and the relay. Returns the least number of samples that a viewer got; 0
  /// without viewers.
  Result<std::uint64_t> End();

 private:
  Result<bool> Start(std::vector<std::string> command, const std::string& session);
  std::filesystem::path Report(std::size_t viewer) const;

  std::unique_ptr<TemporaryFolder> folder_ = std::make_unique<TemporaryFolder>();
  std::vector<ChildProcess> processes_;  // the relay first
};

}  // namespace tandem
