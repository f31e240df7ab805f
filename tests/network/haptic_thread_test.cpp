#include <atomic>
#include <cstdlib>

#include <dds/dds.h>
#undef restrict
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>

#include "tests/network/own_peer.h"
#include "tests/network/real_peers.h"
#include "tests/network/syscall_count.h"
#include "tests/support/allocation_counter.h"

namespace {

// DDS calls of the library under test, by thread: the program's own definitions of them are found
// before Cyclone's, to which they hand on.
thread_local bool in_haptic_frame = false;
std::atomic<long> dds_calls_of_haptic_thread = 0;
std::atomic<long> dds_calls_of_others = 0;

void CountDdsCall() {
  (in_haptic_frame ? dds_calls_of_haptic_thread : dds_calls_of_others).fetch_add(1);
}

template <typename Function>
Function Cyclones(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" dds_return_t dds_write(dds_entity_t writer, const void* data) {
  static const auto real = Cyclones<decltype(&dds_write)>("dds_write");
  CountDdsCall();
  return real(writer, data);
}

extern "C" dds_return_t dds_take(dds_entity_t reader, void** samples, dds_sample_info_t* infos,
                                 size_t size, uint32_t most) {
  static const auto real = Cyclones<decltype(&dds_take)>("dds_take");
  CountDdsCall();
  return real(reader, samples, infos, size, most);
}

namespace tandem {
namespace {

using testing::RealPeers;

bool UnderSanitizer() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return true;
#else
  return false;
#endif
}

TEST(HapticThread, OfARealPeerOnlySleepsAndReadsItsProcessorTime) {
  if (UnderSanitizer()) GTEST_SKIP() << "a sanitizer makes system calls of its own";
  RealPeers peers({.seconds = 3});
  const std::optional<pid_t> haptic = testing::AwaitThread(peers.peer(0).pid(), "haptic");
  ASSERT_TRUE(haptic);
  const auto count = testing::CountSyscalls(*haptic);
  if (!count) GTEST_SKIP() << "ptrace is refused here";
  EXPECT_EQ(peers.Wait(), (std::vector<int>{0, 0}));

  ASSERT_GT(count->sleeps, 3000);
  EXPECT_LE(1000 * count->of(SYS_futex), count->sleeps);
  for (const auto& [call, times] : count->calls) {
    if (call == SYS_futex || call == SYS_clock_gettime) continue;
    EXPECT_EQ(times, 0) << "system call " << call;
  }
  // it was a session: they had one another's loop, and contact
  EXPECT_GT(peers.Report(0).at("delay_ms").get<double>(), 0);
  EXPECT_GT(peers.Report(0).at("contact_share").get<double>(), 0);
}

TEST(HapticThread, OfAPeerOverDdsAllocatesNothingAndCallsNoDds) {
  const RealPeers partner({.count = 1, .seconds = 30});
  constexpr long kFrames = 3000;
  std::atomic<long> frames = 0;
  std::atomic<long> allocations = 0;
  {
    testing::OwnPeer own(partner.session(), 77, [&](PeerNode& node, std::int64_t now_ns) {
      kHapticThread.Enter();
      in_haptic_frame = true;
      long here = 0;
      {
        const testing::AllocationCounter counter;
        node.HapticFrame(now_ns);
        here = counter.count();
      }
      in_haptic_frame = false;
      allocations += here;
      if (node.peer().mean_delay_s() > 0) ++frames;  // the partner is felt
    });
    own.Run(30, [&] {
      return frames >= kFrames;
    });
  }
  ASSERT_GE(frames, kFrames);
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(dds_calls_of_haptic_thread, 0);
  EXPECT_GT(dds_calls_of_others, kFrames);
}

}  // namespace
}  // namespace tandem
