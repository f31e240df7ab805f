#include "engine/realtime/private_process.h"

#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "engine/base/sanitized.h"

namespace tandem {

void KeepProcessPrivate() noexcept {
  if (kIsSanitized) return;
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  // also where cores are piped into a program, for which the limit does not count
  prctl(PR_SET_DUMPABLE, 0);
}

void CloseOthersOnExec() noexcept {
  close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
}

}  // namespace tandem
