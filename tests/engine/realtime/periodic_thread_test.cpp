#include "engine/realtime/periodic_thread.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;

// Time passes only when a sleep or a frame says so.
class ScriptedClock final : public LoopClock {
 public:
  std::int64_t NowNs() noexcept override { return now_; }
  std::int64_t ThreadCpuNs() noexcept override { return cpu_; }
  void SleepUntil(std::int64_t deadline_ns) noexcept override {
    now_ = std::max(now_, deadline_ns) + wake_late_;
  }
  void Work(std::int64_t wall_ns, std::int64_t cpu_ns) {
    now_ += wall_ns;
    cpu_ += cpu_ns;
  }
  void set_wake_late(std::int64_t ns) { wake_late_ = ns; }

 private:
  std::int64_t now_ = 5'000'000'000;
  std::int64_t cpu_ = 77;
  std::int64_t wake_late_ = 0;
};

struct Loop {
  ScriptedClock clock;
  FrameStats stats;
  std::atomic<bool> stop{false};
  std::int64_t start = clock.NowNs();
  std::int64_t origin = start;

  void Run(const PeriodicFrame& frame) {
    RunPeriodically(kPeriod, origin, frame, stop, clock, stats);
  }
};

TEST(RunPeriodically, ReportsEachFramesTime) {
  Loop loop;
  std::vector<std::int64_t> reported;
  RunPeriodically(
      kPeriod, loop.origin,
      [&](std::int64_t frame, std::int64_t) {
        loop.clock.Work(300'000 + frame, 100'000 + frame);
        return frame < 2;
      },
      loop.stop, loop.clock, loop.stats,
      [&](std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns) {
        reported.insert(reported.end(), {start_ns - loop.start, end_ns - start_ns, cpu_ns});
      });
  EXPECT_EQ(reported, (std::vector<std::int64_t>{kPeriod, 300'000, 100'000,      //
                                                 2 * kPeriod, 300'001, 100'001,  //
                                                 3 * kPeriod, 300'002, 100'002}));
}

TEST(RunPeriodically, StartsEachFrameAtItsDeadline) {
  Loop loop;
  std::vector<std::int64_t> numbers;
  std::vector<std::int64_t> starts;
  loop.Run([&](std::int64_t frame, std::int64_t now_ns) {
    numbers.push_back(frame);
    starts.push_back(now_ns - loop.start);
    loop.clock.Work(300'000, 100'000);
    return frame < 3;
  });
  EXPECT_EQ(numbers, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_EQ(starts,
            (std::vector<std::int64_t>{1 * kPeriod, 2 * kPeriod, 3 * kPeriod, 4 * kPeriod}));
  EXPECT_EQ(loop.stats.frames(), 4U);
  EXPECT_EQ(loop.stats.missed(), 0U);
  EXPECT_EQ(loop.stats.wall().max(), 300'000);
  EXPECT_EQ(loop.stats.cpu().max(), 100'000);
  EXPECT_EQ(loop.stats.lateness().max(), 0);
}

TEST(RunPeriodically, SkipsMissedDeadlinesAndKeepsItsGrid) {
  Loop loop;
  std::vector<std::int64_t> starts;
  loop.Run([&](std::int64_t frame, std::int64_t now_ns) {
    starts.push_back(now_ns - loop.start);
    // Frame 1 starts at 2 ms and ends at 5.4 ms: the deadlines at 3, 4 and 5 ms are lost.
    loop.clock.Work(frame == 1 ? 3'400'000 : 10'000, 0);
    return frame < 3;
  });
  EXPECT_EQ(starts,
            (std::vector<std::int64_t>{1 * kPeriod, 2 * kPeriod, 6 * kPeriod, 7 * kPeriod}));
  EXPECT_EQ(loop.stats.frames(), 4U);
  EXPECT_EQ(loop.stats.missed(), 3U);
}

TEST(RunPeriodically, LateWakeUpMissesNoDeadlineIfTheFrameEndsInTime) {
  Loop loop;
  loop.clock.set_wake_late(400'000);
  std::vector<std::int64_t> starts;
  loop.Run([&](std::int64_t frame, std::int64_t now_ns) {
    starts.push_back(now_ns - loop.start);
    loop.clock.Work(500'000, 0);
    return frame < 1;
  });
  EXPECT_EQ(starts, (std::vector<std::int64_t>{1'400'000, 2'400'000}));
  EXPECT_EQ(loop.stats.missed(), 0U);
  EXPECT_EQ(loop.stats.lateness().max(), 400'000);
}

TEST(RunPeriodically, WakeUpLaterThanAPeriodRunsOneFrame) {
  Loop loop;
  std::vector<std::int64_t> starts;
  loop.clock.set_wake_late(2'500'000);
  loop.Run([&](std::int64_t frame, std::int64_t now_ns) {
    starts.push_back(now_ns - loop.start);
    loop.clock.set_wake_late(0);
    return frame < 1;
  });
  // Woken for 1 ms at 3.5 ms: 2 and 3 ms are lost, and 4 ms is next.
  EXPECT_EQ(starts, (std::vector<std::int64_t>{3'500'000, 4'000'000}));
  EXPECT_EQ(loop.stats.missed(), 2U);
  EXPECT_EQ(loop.stats.lateness().max(), 2'500'000);
}

TEST(RunPeriodically, FramesPlusMissedEqualElapsedDeadlines) {
  Loop loop;
  std::int64_t end = 0;
  loop.Run([&](std::int64_t frame, std::int64_t) {
    loop.clock.Work(1 + (frame * 7'919'317) % 2'700'000, 0);
    end = loop.clock.NowNs();
    return frame < 999;
  });
  EXPECT_EQ(loop.stats.frames(), 1000U);
  EXPECT_GT(loop.stats.missed(), 100U);
  EXPECT_EQ(loop.stats.frames() + loop.stats.missed(),
            static_cast<std::uint64_t>((end - loop.start) / kPeriod));
}

TEST(RunPeriodically, StopFlagEndsItBeforeTheNextFrame) {
  Loop loop;
  loop.Run([&](std::int64_t frame, std::int64_t) {
    if (frame == 4) loop.stop = true;
    return true;
  });
  EXPECT_EQ(loop.stats.frames(), 5U);
}

TEST(RunPeriodically, FramesAllocateNothing) {
  Loop loop;
  std::int64_t sum = 0;
  const PeriodicFrame frame = [&](std::int64_t number, std::int64_t) {
    sum += number;
    loop.clock.Work(10'000 + number * 2000, 5000);
    return number < 999;
  };
  const testing::AllocationCounter allocations;
  loop.Run(frame);
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_EQ(sum, 999 * 1000 / 2);
}

TEST(RunPeriodically, KeepsItsPhaseForAnyOrigin) {
  for (const std::int64_t offset : {-7 * kPeriod + 250'000, std::int64_t{250'000}}) {
    Loop loop;
    loop.origin = loop.start + offset;
    std::vector<std::int64_t> starts;
    loop.Run([&](std::int64_t frame, std::int64_t now_ns) {
      starts.push_back(now_ns - loop.start);
      loop.clock.Work(frame == 1 ? 2'600'000 : 300'000, 100'000);  // the second misses deadlines
      return frame < 3;
    });
    const std::int64_t first = offset < 0 ? 250'000 : kPeriod + 250'000;
    EXPECT_EQ(starts, (std::vector<std::int64_t>{first, first + kPeriod, first + 4 * kPeriod,
                                                 first + 5 * kPeriod}));
  }
}

TEST(PeriodicThread, RunsFramesInOrderUntilAFrameStops) {
  std::vector<std::int64_t> numbers;
  std::vector<std::int64_t> starts;
  const std::int64_t before = MonotonicNowNs();
  PeriodicThread thread({.period_ns = kPeriod, .priority = 0},
                        [&](std::int64_t frame, std::int64_t now_ns) {
                          numbers.push_back(frame);
                          starts.push_back(now_ns);
                          return frame < 19;
                        });
  thread.Join();
  ASSERT_EQ(numbers.size(), 20U);
  EXPECT_EQ(numbers.back(), 19);
  // Sleeps may end late, never early: frame k stands at deadline k + 1 or, after skipping, a later
  // one.
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_GE(starts[i], before + static_cast<std::int64_t>(i + 1) * kPeriod);
  }
  EXPECT_EQ(thread.stats().frames(), 20U);
  EXPECT_EQ(thread.realtime().scheduler(), std::string("SCHED_OTHER"));
}

TEST(PeriodicThread, StopEndsAnEndlessLoop) {
  std::promise<void> running;
  PeriodicThread thread({.period_ns = kPeriod, .priority = 0},
                        [&](std::int64_t frame, std::int64_t) {
                          if (frame == 2) running.set_value();
                          return true;
                        });
  running.get_future().wait();
  thread.Stop();
  thread.Join();
  EXPECT_GE(thread.stats().frames(), 3U);
}

TEST(PeriodicThread, FrameOnTheMachinesClockAllocatesNothing) {
  long allocated = -1;
  std::optional<testing::AllocationCounter> allocations;
  PeriodicThread thread({.period_ns = 20'000, .priority = 0},
                        [&](std::int64_t frame, std::int64_t) {
                          if (frame == 0) allocations.emplace();
                          if (frame < 1000) return true;
                          allocated = allocations->count();
                          allocations.reset();
                          return false;
                        });
  thread.Join();
  EXPECT_EQ(allocated, 0);
}

}  // namespace
}  // namespace tandem
