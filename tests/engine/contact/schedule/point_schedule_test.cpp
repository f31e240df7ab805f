#include "engine/contact/schedule/point_schedule.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/engine/contact/schedule/random_walk.h"

namespace tandem {
namespace {

using testing::Bodies;
using testing::Outcome;
using testing::PointFrames;
using testing::Rods;
using testing::RunRandomWalk;

// Tests the invariant of the schedule, under everything that could break it.
TEST(PointSchedule, TestsEveryPointInContactInThatFrame) {
  const Bodies bodies = Rods();
  const int trials = 8;
  const int frames =
      static_cast<int>(PointFrames() / trials / static_cast<double>(bodies.shell.size()));
  double squeezed = 0;
  double point_frames = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const ScheduleOptions options{
        .experiments = {.chunks = (trial & 1) == 0, .drift = (trial & 2) == 0}};
    const double points = static_cast<double>(bodies.shell.size());
    const double capacity = ((trial & 4) == 0 ? 0.15 : 0.3) * points;
    const Outcome outcome =
        RunRandomWalk(bodies, options, capacity, frames, 77 + static_cast<std::uint64_t>(trial));
    EXPECT_EQ(outcome.missed, 0U) << "trial " << trial;
    EXPECT_GT(outcome.contacts, 0.5) << "trial " << trial;
    if (trial < 4) {
      EXPECT_LT(outcome.tests, 0.5 * points) << "trial " << trial;
    }
    squeezed += outcome.squeezed / trials;
    point_frames += outcome.point_frames;
    const std::string key = "trial_" + std::to_string(trial);
    RecordProperty(key + "_tests", std::to_string(outcome.tests));
    RecordProperty(key + "_over", std::to_string(outcome.over));
  }
  RecordProperty("point_frames", std::to_string(point_frames));
  RecordProperty("squeezed", std::to_string(squeezed));
  EXPECT_GT(squeezed, 0.5);
}

// Marks have four bits and eight, within and beyond what the queues tell apart.
TEST(PointSchedule, TestsEveryPointInContactForAnyRange) {
  for (const int range : {5, 13, 14, 60}) {
    const Bodies bodies = Rods(range);
    const double points = static_cast<double>(bodies.shell.size());
    const Outcome outcome = RunRandomWalk(bodies, {}, 0.3 * points, static_cast<int>(2e6 / points),
                                          900 + static_cast<std::uint64_t>(range));
    EXPECT_EQ(outcome.missed, 0U) << "range " << range;
    EXPECT_GT(outcome.contacts, 0.5) << "range " << range;
  }
}

// Points finer than the map's voxels (paper §3.2, Table 1: 1.0 mm in 2.5 mm): chunks of theirs are
// smaller than the map's, blocks lie closer together; allowances are the map's.
TEST(PointSchedule, TestsEveryPointInContactWithPointsFinerThanVoxels) {
  for (const double spacing : {0.7, 0.4, 0.15}) {
    const Bodies bodies = Rods(kDefaultRange, spacing);
    const double points = static_cast<double>(bodies.shell.size());
    EXPECT_GT(points, 0.8 * static_cast<double>(Rods().shell.size()) / (spacing * spacing));
    for (const bool chunks : {true, false}) {
      ScheduleOptions options;
      options.experiments.chunks = chunks;
      const Outcome outcome =
          RunRandomWalk(bodies, options, 0.2 * points, static_cast<int>(1e7 / points),
                        910 + static_cast<std::uint64_t>(100 * spacing));
      EXPECT_EQ(outcome.missed, 0U) << "spacing " << spacing << ", chunks " << chunks;
      EXPECT_GT(outcome.contacts, 0.5) << "spacing " << spacing;
      EXPECT_LT(outcome.tests, 0.5 * points) << "spacing " << spacing;
    }
  }
}

}  // namespace
}  // namespace tandem
