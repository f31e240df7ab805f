#include "app/bench/reference/printed_schedule.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/engine/contact/schedule/random_walk.h"
#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

using testing::Bodies;
using testing::kVoxel;
using testing::Outcome;
using testing::PointFrames;
using testing::Rods;
using testing::RunRandomWalk;

// The same pushes go to the same bodies, each held to the travel that its own schedule allows.
TEST(PrintedSchedule, MissesContactsThatOurScheduleFinds) {
  const Bodies bodies = Rods();
  const auto points = static_cast<double>(bodies.shell.size());
  const int trials = 8;
  const int frames = static_cast<int>(0.5 * PointFrames() / trials / points);
  std::size_t printed_missed = 0;
  for (int trial = 0; trial < trials; ++trial) {
    ScheduleOptions options{.experiments = {.chunks = (trial & 1) == 0, .drift = (trial & 2) == 0}};
    const double capacity = ((trial & 4) == 0 ? 0.1 : 0.2) * points;
    const auto seed = 177 + static_cast<std::uint64_t>(trial);
    const Outcome ours = RunRandomWalk(bodies, options, capacity, frames, seed);
    options.instead = MakePrintedSchedule;
    const Outcome printed = RunRandomWalk(bodies, options, capacity, frames, seed);
    EXPECT_EQ(ours.missed, 0U) << "trial " << trial;
    // the printed schedule works, but for being late
    EXPECT_GT(printed.contacts, 0.3) << "trial " << trial;
    EXPECT_LT(printed.tests, 0.5 * points) << "trial " << trial;
    printed_missed += printed.missed;
    const std::string key = "trial_" + std::to_string(trial);
    RecordProperty(key + "_missed", static_cast<int>(printed.missed));
    RecordProperty(key + "_tests", std::to_string(ours.tests));
    RecordProperty(key + "_over", std::to_string(ours.over));
    RecordProperty(key + "_printed_tests", std::to_string(printed.tests));
    RecordProperty(key + "_printed_over", std::to_string(printed.over));
  }
  RecordProperty("missed", static_cast<int>(printed_missed));
  EXPECT_GT(printed_missed, 0U);
}

TEST(PrintedSchedule, DoesNotAllocate) {
  const Bodies bodies = Rods();
  PrintedSchedule schedule(bodies.blocks, bodies.voxmap, 1, {});
  const testing::AllocationCounter allocations;
  std::size_t contacts = 0;
  for (int frame = 0; frame < 40; ++frame) {
    const Pose X_WS{Quat::Identity(), Vec3(0, 0, 0.3 - 0.5 * kVoxel * frame)};
    schedule.Test(bodies.X_MV().Inverse() * X_WS, 0.5 * kVoxel);
    contacts += schedule.contacts().size();
    if (frame == 20) schedule.SetDisplacement(0.5 * kVoxel);
    if (frame == 30) schedule.SetForceLayer(2);
  }
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_GT(contacts, 0U);
}

}  // namespace
}  // namespace tandem
