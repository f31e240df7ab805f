#include "engine/realtime/realtime_setup.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "engine/base/sanitized.h"

namespace tandem {
namespace {

using ::testing::ExitedWithCode;
using ::testing::HasSubstr;
using ::testing::Not;

// Sanitizers answer mlockall() themselves: with success, and nothing is locked.
constexpr bool kLocksForReal = !kIsSanitized;

// Returns the number of "VmLck:      4096 kB" of this process.
long LockedKilobytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmLck:", 0) == 0) return std::atol(line.c_str() + 6);
  }
  return -1;
}

bool Expect(bool holds, const char* claim) {
  if (!holds) std::fprintf(stderr, "not so: %s\n", claim);
  return holds;
}

// Runs in a child process, which then exits: 0 when the kernel agrees with the status.
[[noreturn]] void EnterAndCompareWithTheKernel() {
  const RealtimeStatus status = EnterRealtime(7);
  sched_param parameters{};
  sched_getparam(0, &parameters);
  const int policy = sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
  bool agrees = Expect(status.fifo == (policy == SCHED_FIFO), "fifo");
  agrees &= Expect(status.priority == parameters.sched_priority, "priority");
  // 1 ns as asked; newer kernels keep 0 for SCHED_FIFO whatever is asked.
  agrees &= Expect(status.timer_slack == (prctl(PR_GET_TIMERSLACK) <= 1), "timer slack");
  if (kLocksForReal) {
    agrees &= Expect(status.memory_locked == (LockedKilobytes() > 1000), "memory locked");
  }
  agrees &= Expect(status.stack_prefaulted, "stack prefaulted");
  agrees &= Expect(status.warning.empty() == (status.fifo && status.memory_locked), "warning");
  std::_Exit(agrees ? 0 : 1);
}

[[noreturn]] void EnterWithoutRights() {
  const rlimit none{0, 0};
  const rlimit little{1 << 20, 1 << 20};
  setrlimit(RLIMIT_RTPRIO, &none);
  setrlimit(RLIMIT_MEMLOCK, &little);
  if (geteuid() == 0 && setresuid(65534, 65534, 65534) != 0) std::_Exit(2);

  const RealtimeStatus status = EnterRealtime(7);
  bool as_expected = Expect(!status.fifo && status.priority == 0, "no fifo");
  as_expected &= Expect(!status.memory_locked, "memory not locked");
  as_expected &= Expect(status.timer_slack, "timer slack is granted to anybody");
  as_expected &= Expect(status.warning.find("limits.d") != std::string::npos, "a way to mend it");
  // A limited mlockall would break the use of memory beyond the limit.
  constexpr std::size_t kSize = std::size_t{64} << 20;
  void* block = std::malloc(kSize);
  as_expected &= Expect(block != nullptr, "64 MiB can still be had");
  if (block != nullptr) std::memset(block, 1, kSize);
  std::_Exit(as_expected ? 0 : 1);
}

TEST(EnterRealtime, ReportsWhatTheKernelGranted) {
  EXPECT_EXIT(EnterAndCompareWithTheKernel(), ExitedWithCode(0), "");
}

TEST(EnterRealtime, MissingRightsAreReportedAndMemoryStaysUsable) {
  EXPECT_EXIT(EnterWithoutRights(), ExitedWithCode(0), "");
}

TEST(RealtimeWarning, IsEmptyWhenAllWasGranted) {
  const RealtimeStatus all{.fifo = true,
                           .priority = 30,
                           .timer_slack = true,
                           .memory_locked = true,
                           .stack_prefaulted = true,
                           .warning = {}};
  EXPECT_EQ(RealtimeWarning(all, 30, "ann"), "");
}

TEST(RealtimeWarning, NamesMissingRightsAndTheirRemedy) {
  RealtimeStatus status{.fifo = false,
                        .priority = 0,
                        .timer_slack = true,
                        .memory_locked = false,
                        .stack_prefaulted = true,
                        .warning = {}};
  const std::string both = RealtimeWarning(status, 30, "ann");
  EXPECT_THAT(both, HasSubstr("'ann - rtprio 30'"));
  EXPECT_THAT(both, HasSubstr("'ann - memlock unlimited'"));
  EXPECT_THAT(both, HasSubstr("/etc/security/limits.d/"));
  EXPECT_THAT(both, Not(HasSubstr("\n")));

  status.fifo = true;
  const std::string memory_only = RealtimeWarning(status, 30, "ann");
  EXPECT_THAT(memory_only, Not(HasSubstr("rtprio")));
  EXPECT_THAT(memory_only, HasSubstr("memlock unlimited"));
}

}  // namespace
}  // namespace tandem
