#pragma once

namespace tandem {

/// The exit codes of all commands and of the viewer (docs/architecture.md).
enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,
  kExitUsage = 2,
  kExitFile = 3,
  kExitDisplay = 4,
  kExitNetwork = 5,
  kExitDevice = 6,
  kExitNotRealTime = 7,
  kExitIncompatiblePeer = 8,
  kExitSecurity = 9
};

}  // namespace tandem
