#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/child_processes.h"

namespace tandem {

/// Those who look on at a session behind a relay, each a process; they stay until they are asked.
class Audience {
 public:
  /// Of `count`; none: no relay either.
  static Result<Audience> Gather(const std::string& session, std::size_t count);

  /// Sends them home. Gives the fewest pictures that one of them got; 0 without any.
  Result<std::uint64_t> Leave();

 private:
  Result<bool> Start(std::vector<std::string> command, const std::string& session);
  std::filesystem::path Report(std::size_t viewer) const;

  std::unique_ptr<TemporaryFolder> folder_ = std::make_unique<TemporaryFolder>();
  std::vector<ChildProcess> processes_;  // the relay first
};

}  // namespace tandem
