#include "engine/realtime/worker_pool.h"

#include <atomic>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/realtime/clock.h"
#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

constexpr WorkerPool::Options kFour{.threads = 4, .priority = 0};

// Judges a share: it must have every place once, by threads that there are.
struct Marks {
  explicit Marks(std::size_t count) : times(count, 0) {}
  void operator()(std::size_t begin, std::size_t end, int thread) const {
    for (std::size_t i = begin; i < end; ++i) ++times[i];
    if (thread < 0 || thread >= threads || begin >= end) wrong.fetch_add(1);
  }
  mutable std::vector<int> times;
  int threads = 1;
  mutable std::atomic<int> wrong{0};
};

TEST(WorkerPool, EveryItemIsProcessedOnce) {
  WorkerPool workers(kFour);
  for (const std::size_t count : {0U, 1U, 7U, 128U, 129U, 1000U, 4096U}) {
    for (const std::size_t piece : {1U, 3U, 128U, 5000U}) {
      Marks marks(count);
      marks.threads = workers.threads();
      workers.WakeWorkers();
      workers.ParallelFor(count, piece, marks);
      EXPECT_EQ(marks.times, std::vector<int>(count, 1)) << count << " by " << piece;
      EXPECT_EQ(marks.wrong.load(), 0);
      workers.ReleaseWorkers();
    }
  }
}

TEST(WorkerPool, SingleThreadProcessesEverything) {
  WorkerPool workers({.threads = 1, .priority = 0});
  EXPECT_EQ(workers.threads(), 1);
  EXPECT_EQ(workers.CpuNs(), 0);
  const std::thread::id caller = std::this_thread::get_id();
  int elsewhere = 0;
  workers.WakeWorkers();
  workers.ParallelFor(1000, 10, [&](std::size_t, std::size_t, int thread) {
    elsewhere += static_cast<int>(thread != 0 || std::this_thread::get_id() != caller);
  });
  workers.ReleaseWorkers();
  EXPECT_EQ(elsewhere, 0);
}

// Sums are of plain numbers: a thread sanitizer sees whether they are handed over properly.
TEST(WorkerPool, LosesNothingInAHundredThousandCalls) {
  WorkerPool workers(kFour);
  constexpr std::size_t kCount = 12;
  std::vector<std::uint64_t> in(kCount);
  std::vector<std::uint64_t> out(kCount);
  std::uint64_t wrong = 0;
  for (std::uint64_t post = 0; post < 100'000; ++post) {
    // a frame has five posts, and some frames call nobody
    if (post % 5 == 0 && post % 3 != 0) workers.WakeWorkers();
    std::iota(in.begin(), in.end(), post);
    workers.ParallelFor(kCount, 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) out[i] = 3 * in[i] + 1;
    });
    for (std::size_t i = 0; i < kCount; ++i) {
      wrong += static_cast<std::uint64_t>(out[i] != 3 * (post + i) + 1);
    }
    if (post % 5 == 4) workers.ReleaseWorkers();
  }
  EXPECT_EQ(wrong, 0U);
}

// The caller leaves the last pieces to the workers, which take their time.
TEST(WorkerPool, SlowHelpersAreAwaited) {
  WorkerPool workers(kFour);
  if (workers.threads() == 1) GTEST_SKIP() << "one processor";
  for (int frame = 0; frame < 20; ++frame) {
    std::atomic<int> begun{0};
    std::vector<std::uint64_t> out(2, 0);
    workers.WakeWorkers();
    workers.ParallelFor(2, 1, [&](std::size_t begin, std::size_t, int thread) {
      begun.fetch_add(1);
      // nobody ends before both pieces have begun, so two threads are at it
      const std::int64_t until = MonotonicNowNs() + 2'000'000'000;
      while (begun.load() < 2 && MonotonicNowNs() < until) std::this_thread::yield();
      std::uint64_t sum = 0;
      const std::uint64_t work = thread == 0 ? 1 : 300'000;
      for (std::uint64_t i = 0; i < work; ++i) sum = sum * 6364136223846793005U + i;
      out[begin] = sum | 1;
    });
    EXPECT_EQ(begun.load(), 2);
    EXPECT_NE(out[0], 0U);
    EXPECT_NE(out[1], 0U);
    workers.ReleaseWorkers();
  }
  EXPECT_GT(workers.CpuNs(), 0);
}

TEST(WorkerPool, StartsAndStopsWithAndWithoutWork) {
  for (int round = 0; round < 50; ++round) {
    WorkerPool workers(kFour);
    if (round % 3 == 0) continue;
    workers.WakeWorkers();
    Marks marks(100);
    marks.threads = workers.threads();
    if (round % 3 == 1) workers.ParallelFor(100, 1, marks);
    if (round % 2 == 0) workers.ReleaseWorkers();
    EXPECT_EQ(marks.wrong.load(), 0);
  }
}

TEST(WorkerPool, MissingHelpersAreNotNeeded) {
  // no worker is awake: the caller does all that it shares
  WorkerPool workers(kFour);
  Marks marks(500);
  marks.threads = 1;
  workers.ParallelFor(500, 7, marks);
  EXPECT_EQ(marks.times, std::vector<int>(500, 1));
  EXPECT_EQ(marks.wrong.load(), 0);
}

TEST(WorkerPool, CallersFrameAllocatesNothing) {
  WorkerPool workers(kFour);
  std::vector<int> out(1000, 0);
  const testing::AllocationCounter allocations;
  for (int frame = 0; frame < 1000; ++frame) {
    workers.WakeWorkers();
    workers.ParallelFor(out.size(), 16, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) ++out[i];
    });
    workers.ReleaseWorkers();
  }
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_EQ(out, std::vector<int>(1000, 1000));
}

}  // namespace
}  // namespace tandem
