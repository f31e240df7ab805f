#include "app/bench/measure/timed_frames.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <sys/resource.h>

#include "app/bench/measure/all_points.h"
#include "app/bench/measure/bench_scene.h"
#include "app/bench/measure/empty_work.h"
#include "app/capacity/capacity_follower.h"
#include "app/common/console.h"
#include "engine/base/units.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem {

namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr int kSizeEvery = 500;  // frames between two new sizes of the empty work

/// Returns the page faults of the calling thread or, where workers share a frame, of all threads.
long PageFaults(const WorkerPool& workers) {
  rusage usage{};
  getrusage(workers.threads() > 1 ? RUSAGE_SELF : RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

/// Returns inputs for a world whose first body a hand holds.
StepInputs InputsOf(const World& world, const Pose& X_BD, const FrameCapacity& capacity) {
  StepInputs inputs = ParkedInputs(world.model());
  inputs.instances[0].drive = BodyDrive::kSimulated;
  inputs.capacity = capacity.tests;
  inputs.query_price = capacity.query_price;
  inputs.hand = {.body = 0,
                 .X_BD = X_BD,
                 .goal = {},
                 .gains = DefaultHandGains(world.model().bodies[0].inertia)};
  return inputs;
}

/// Returns the point tests that all pairs owe in the next frame, however far it goes.
std::int64_t OwedTests(const World& world) {
  TestDemand demand;
  for (std::size_t pair = 0; pair < world.pair_count(); ++pair)
    demand += world.pair(pair).test_demand();
  return std::llround(demand.mandatory);
}

/// The times and counts of one frame.
struct StepTimes {
  std::int64_t start_ns = 0;  // start of the frame by the loop
  std::int64_t end_ns = 0;
  std::int64_t cpu_ns = 0;
  std::int64_t wall_ns = 0;
  std::int64_t workers_ns = 0;
  long faults = 0;
};

/// Steps the world and takes the frame's times.
StepTimes TimeStep(World& world, const StepInputs& inputs, const WorkerPool& workers,
                   std::optional<CapacityFollower>& follower, StepReport& report) {
  LoopClock& clock = MachineClock();
  StepTimes times;
  const long faults = PageFaults(workers);
  const std::int64_t helped = workers.CpuNs();
  const std::int64_t wall = clock.NowNs();
  const std::int64_t cpu = clock.ThreadCpuNs();
  report = world.Step(inputs);
  times.cpu_ns = clock.ThreadCpuNs() - cpu;
  times.end_ns = clock.NowNs();
  times.wall_ns = times.end_ns - wall;
  if (follower && report.waited == 0) {
    follower->Count(report, ToSeconds(times.cpu_ns));
  }
  times.faults = PageFaults(workers) - faults;
  times.workers_ns = workers.CpuNs() - helped;
  return times;
}

/// Counts a frame that waits for voxels. Returns whether it may wait longer.
bool CountWait(const StepReport& report, long faults, FrameFigures& figures) {
  VoxelWaits& waits = figures.waits;
  ++waits.frames;
  waits.count += report.waited == 1 ? 1 : 0;
  waits.longest = std::max(waits.longest, report.waited);
  figures.page_faults += faults;
  return report.waited < kLongestVoxelWait;
}

/// Does empty work of the frames' length, and times it once its size is known.
void RunNoise(EmptyWork& noise, FrameFigures& figures) {
  LoopClock& clock = MachineClock();
  if (figures.frames % kSizeEvery == 0 && figures.frames > 0) {
    noise.Size(static_cast<double>(figures.cpu.Quantile(0.5)));
  }
  const std::int64_t begin = clock.ThreadCpuNs();
  noise();
  if (figures.frames >= kSizeEvery) figures.noise.Add(clock.ThreadCpuNs() - begin);
}

void CountTimes(const StepTimes& times, const StepReport& report, std::int64_t origin_ns,
                FrameFigures& figures) {
  figures.cpu.Add(times.cpu_ns);
  figures.workers_cpu.Add(times.workers_ns);
  if (times.cpu_ns > figures.worst_ns) {
    figures.worst_ns = times.cpu_ns;
    figures.worst = report;
  }
  figures.wall.Add(times.wall_ns);
  figures.over_1ms += times.wall_ns > kPeriodNs ? 1 : 0;
  figures.missed +=
      (times.end_ns - origin_ns) / kPeriodNs - (times.start_ns - origin_ns) / kPeriodNs;
  figures.page_faults += times.faults;
}

void CountWork(const StepReport& report, FrameFigures& figures) {
  figures.contacts += report.contact_points;
  figures.exact_queries += report.exact_queries;
  figures.pushing_points += report.pushing_points;
  figures.tests += static_cast<double>(report.tests.looked_up + report.tests.compared);
  figures.drifted += static_cast<double>(report.tests.drifted);
  figures.chunks += static_cast<double>(report.tests.chunks);
  figures.held_back += (report.flags & StepReport::kTravelLimited) != 0;
  figures.at_bound += (report.flags & StepReport::kOverCapacity) == 0;
}

}  // namespace

void RunBackToBack(World& world, const FrameHand& hand, const Pose& X_BD,
                   const FrameCapacity& capacity, std::vector<std::int64_t>& least_ns,
                   const std::function<void()>& after) {
  StepInputs inputs = InputsOf(world, X_BD, capacity);
  LoopClock& clock = MachineClock();
  StepReport report;
  const auto frames = kWarmUp + static_cast<std::int64_t>(least_ns.size());
  for (std::int64_t frame = 0; frame < frames; ++frame) {
    inputs.hand.goal = hand(frame, report);
    const std::int64_t begin = clock.ThreadCpuNs();
    report = world.Step(inputs);
    const std::int64_t cpu_ns = clock.ThreadCpuNs() - begin;
    const std::int64_t until_ns = clock.NowNs() + kLongestVoxelWait * kPeriodNs;
    while (report.waited > 0 && clock.NowNs() < until_ns) {
      world.WaitForVoxels();
      report = world.Step(inputs);
    }
    if (after) after();
    if (frame < kWarmUp) continue;
    std::int64_t& least = least_ns[static_cast<std::size_t>(frame - kWarmUp)];
    least = std::min(least, cpu_ns);
  }
}

void RunFrames(World& world, const FrameHand& hand, const Pose& X_BD, const FrameCapacity& capacity,
               double budget_s, int frames, int check_every, const WorkerPool& workers,
               FrameFigures& figures) {
  StepInputs inputs = InputsOf(world, X_BD, capacity);
  std::optional<CapacityFollower> follower;
  if (budget_s > 0) follower.emplace(capacity.tests, capacity.query_price, budget_s);
  AllPoints all(world);
  EmptyWork noise;
  StepReport report;
  const std::int64_t origin_ns = MonotonicNowNs();
  PeriodicThread thread(
      {.period_ns = kPeriodNs, .origin_ns = origin_ns, .priority = kFramePriority},
      [&](std::int64_t deadline, std::int64_t start_ns) {
        const bool waited = report.waited > 0;
        const std::int64_t frame = deadline - figures.waits.frames;
        // the hand stands still while a frame waits for voxels
        if (!waited) inputs.hand.goal = hand(frame, report);
        if (follower) inputs.capacity = follower->tests();
        all.Remember();
        StepTimes times = TimeStep(world, inputs, workers, follower, report);
        times.start_ns = start_ns;
        if (report.waited > 0) return CountWait(report, times.faults, figures);
        if (frame < kWarmUp) return true;
        RunNoise(noise, figures);
        CountTimes(times, report, origin_ns, figures);
        CountWork(report, figures);
        figures.owed.Add(OwedTests(world));
        figures.capacity += inputs.capacity;
        ++figures.frames;
        // violations cannot be counted where part of the voxels is not in memory
        if (frame % check_every == 0 && world.resident_voxels() == nullptr) {
          figures.violations += all.Violations();
          figures.point_frames += static_cast<double>(all.count());
        }
        return figures.frames < frames;
      });
  thread.Join();
  static bool reported = false;  // the warning comes once, in the first of several runs
  if (!thread.realtime().fifo && !std::exchange(reported, true)) Say(thread.realtime().warning);
}

}  // namespace tandem
