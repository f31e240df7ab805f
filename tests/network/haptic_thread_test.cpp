#include <atomic>
#include <cstdlib>

#include <dds/dds.h>
#undef restrict
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>

#include "engine/base/sanitized.h"
#include "tests/network/dds_calls.h"
#include "tests/network/in_process_peer.h"
#include "tests/network/real_peers.h"
#include "tests/network/syscall_count.h"
#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Key;
using testing::RealPeers;

TEST(HapticThread, MakesOnlySleepAndClockSystemCalls) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer makes system calls of its own";
  RealPeers peers({.seconds = 3});
  const std::optional<pid_t> haptic = testing::AwaitThread(peers.peer(0).pid(), "haptic");
  ASSERT_TRUE(haptic);
  const auto count = testing::CountSyscalls(*haptic);
  if (!count) GTEST_SKIP() << "ptrace is refused here";
  EXPECT_EQ(peers.Wait(), (std::vector<int>{0, 0}));

  ASSERT_GT(count->sleeps, 3000);
  EXPECT_LE(1000 * count->of(SYS_futex), count->sleeps);
  // at each end of a frame, and some while it starts
  EXPECT_LE(count->of(SYS_clock_gettime), 2 * count->sleeps + 20);
  for (const auto& [call, times] : count->calls) {
    if (call == SYS_futex || call == SYS_clock_gettime) continue;
    EXPECT_EQ(times, 0) << "system call " << call;
  }
  // it was a session: they had one another's loop, and contact
  EXPECT_GT(peers.Report(0).at("delay_ms").get<double>(), 0);
  EXPECT_GT(peers.Report(0).at("contact_share").get<double>(), 0);
}

TEST(HapticThread, AllocatesNothingAndCallsNoDds) {
  // every function of DDS that is called anywhere in here is counted
  EXPECT_THAT(testing::WatchDdsCalls(), IsEmpty());
  {
    const testing::DdsCallsInside inside;
    EXPECT_STREQ(dds_strretcode(DDS_RETCODE_OK), "Success");
  }
  const std::map<std::string, long> one{{"dds_strretcode", 1}};
  EXPECT_EQ(testing::CountedDdsCalls().inside, one);
  const RealPeers partner({.count = 1, .seconds = 30});
  constexpr long kFrames = 3000;
  std::atomic<long> frames = 0;
  std::atomic<long> allocations = 0;
  {
    testing::InProcessPeer own(partner.session(), 77, [&](PeerNode& node, std::int64_t now_ns) {
      kHapticThread.Enter();
      {
        const testing::DdsCallsInside inside;
        const testing::AllocationCounter counter;
        node.HapticFrame(now_ns);
        allocations += counter.count();
      }
      if (node.peer().mean_delay_s() > 0) ++frames;  // the partner is felt
    });
    own.Run(30, [&] {
      return frames >= kFrames;
    });
  }
  ASSERT_GE(frames, kFrames);
  EXPECT_EQ(allocations, 0);
  const testing::DdsCalls calls = testing::CountedDdsCalls();
  EXPECT_EQ(calls.inside, one);  // as before
  EXPECT_GT(calls.outside.at("dds_write"), kFrames);
  EXPECT_THAT(calls.outside, IsSupersetOf({Key("dds_take"), Key("dds_waitset_wait"),
                                           Key("dds_wait_for_acks"), Key("dds_create_writer")}));
}

}  // namespace
}  // namespace tandem
