#include "collab/dds/cyclone/cyclone_threads.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include <dds/dds.h>
#include <dds/ddsrt/sync.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

#ifdef TANDEM_STEPPED_CLOCK

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::Ge;
using ::testing::Lt;
using Clock = std::chrono::steady_clock;

constexpr std::int64_t kDayNs = 86'400'000'000'000;

void StepClock(const std::string& file, std::int64_t step_ns) {
  std::fstream(file, std::ios::binary | std::ios::in | std::ios::out)
      .write(reinterpret_cast<const char*>(&step_ns), sizeof step_ns);
}

/// Returns how long such a wait of Cyclone's takes while the wall clock is stepped, in seconds.
template <typename Wait>
double SecondsOf(Wait wait, std::int64_t step_ns) {
  ddsrt_mutex_t mutex;
  ddsrt_cond_t condition;
  ddsrt_mutex_init(&mutex);
  ddsrt_cond_init(&condition);
  const auto begun = Clock::now();
  std::thread sets([step_ns] {
    std::this_thread::sleep_for(milliseconds(100));
    StepClock(std::getenv("STEPPED_CLOCK"), step_ns);  // NOLINT(concurrency-mt-unsafe)
  });
  ddsrt_mutex_lock(&mutex);
  EXPECT_FALSE(wait(&condition, &mutex)) << "nobody signals it";
  ddsrt_mutex_unlock(&mutex);
  const double seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  sets.join();
  ddsrt_cond_destroy(&condition);
  ddsrt_mutex_destroy(&mutex);
  return seconds;
}

/// Runs in a process of its own, which has the clock that can be stepped.
void WaitUnderAClockThatIsStepped() {
  const auto wait_for = [](ddsrt_cond_t* condition, ddsrt_mutex_t* mutex) {
    return ddsrt_cond_waitfor(condition, mutex, DDS_MSECS(400));
  };
  const auto wait_until = [](ddsrt_cond_t* condition, ddsrt_mutex_t* mutex) {
    return ddsrt_cond_waituntil(condition, mutex, dds_time() + DDS_MSECS(400));
  };
  const dds_time_t before = dds_time();
  for (const std::int64_t step_ns : {-kDayNs, kDayNs, -2 * kDayNs}) {
    EXPECT_THAT(SecondsOf(wait_for, step_ns), AllOf(Ge(0.39), Lt(5))) << step_ns;
    EXPECT_THAT(SecondsOf(wait_until, -step_ns), AllOf(Ge(0.39), Lt(5))) << step_ns;
  }
  EXPECT_GT(dds_time() - before, kDayNs) << "the clock was not stepped";
}

// Cyclone's thread "tev" sends its announcements and finds out who has fallen silent. If it slept a
// day longer, a peer would not come back after a cut.
TEST(CycloneThreads, WakeInTimeWhenTheWallClockIsSet) {
  if (std::getenv("STEPPED_CLOCK") != nullptr) return WaitUnderAClockThatIsStepped();  // NOLINT
  const ScratchFolder folder;
  const std::string clock = (folder.path() / "clock").string();
  constexpr std::int64_t kNoStep = 0;
  std::ofstream(clock, std::ios::binary)
      .write(reinterpret_cast<const char*>(&kNoStep), sizeof kNoStep);
  const pid_t child = fork();
  if (child == 0) {
    setenv("LD_PRELOAD", TANDEM_STEPPED_CLOCK, 1);
    setenv("STEPPED_CLOCK", clock.c_str(), 1);
    execl("/proc/self/exe", "dds_wire_test",
          "--gtest_filter=CycloneThreads.WakeInTimeWhenTheWallClockIsSet", nullptr);
    _exit(127);
  }
  int status = -1;
  pid_t ended = 0;
  const auto until = Clock::now() + std::chrono::seconds(40);
  while (ended == 0 && Clock::now() < until) {
    std::this_thread::sleep_for(milliseconds(10));
    ended = waitpid(child, &status, WNOHANG);
  }
  if (ended == 0) {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
  EXPECT_TRUE(ended == child && WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

#else

TEST(CycloneThreads, WakeInTimeWhenTheWallClockIsSet) {
  GTEST_SKIP() << "a sanitizer's own library must be loaded first";
}

#endif

}  // namespace
}  // namespace tandem
