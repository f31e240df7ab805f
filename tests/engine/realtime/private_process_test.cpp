#include "engine/realtime/private_process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "engine/base/sanitized.h"

namespace tandem {
namespace {

/// Makes this process private, and ends it with code 0 if the kernel then writes no core of it.
[[noreturn]] void EndPrivately() {
  const bool before = prctl(PR_GET_DUMPABLE) == 1;
  KeepProcessPrivate();
  rlimit core{};
  getrlimit(RLIMIT_CORE, &core);
  _exit(before && prctl(PR_GET_DUMPABLE) == 0 && core.rlim_max == 0 ? 0 : 1);
}

/// Ends this process with code 0 if a further descriptor is closed on exec and stderr is not.
[[noreturn]] void EndWithDescriptors() {
  const int one = open("/dev/null", O_RDONLY);
  CloseOthersOnExec();
  const bool closes = (fcntl(one, F_GETFD) & FD_CLOEXEC) != 0;
  const bool stays = (fcntl(STDERR_FILENO, F_GETFD) & FD_CLOEXEC) == 0;
  _exit(closes && stays ? 0 : 1);
}

// processes of their own, since neither can be undone
TEST(PrivateProcessDeathTest, LeavesNoCore) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer looks into its own process";
  EXPECT_EXIT(EndPrivately(), ::testing::ExitedWithCode(0), "");
}

TEST(PrivateProcessDeathTest, DescriptorsEndWithTheProgram) {
  EXPECT_EXIT(EndWithDescriptors(), ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace tandem
