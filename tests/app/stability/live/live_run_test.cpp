#include "app/stability/live/live_run.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/stability/live/live_comparison.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

/// Records a try in which this many of 10,000 frames were missed. As a peer does, it never writes
/// over a recording that is there.
Result<LiveRun> Record(const std::filesystem::path& folder, std::uint64_t missed) {
  const std::filesystem::path recording = folder / "user-0.recording";
  if (std::filesystem::exists(recording)) return Error{recording.string() + " exists already"};
  std::ofstream(recording) << missed;
  if (!std::filesystem::exists(recording)) return Error{recording.string() + " cannot be written"};
  LiveRun run;
  run.missed = missed;
  run.frames = 10'000 - missed;
  return run;
}

TEST(TryLive, RepeatsAnAttemptOnABusyMachine) {
  const ScratchFolder scratch;
  std::uint64_t missed = 130;
  const Result<LiveTries> tries =
      TryLive(scratch.path() / "kept", [&missed](const std::filesystem::path& folder) {
        return Record(folder, std::exchange(missed, 3));
      });
  ASSERT_TRUE(tries) << tries.error().what;
  EXPECT_EQ(tries->count, 2);
  EXPECT_EQ(tries->last.missed, 3U);
  EXPECT_EQ(tries->folder, scratch.path() / "kept" / "try-2");
  for (const auto& [name, frames] : {std::pair("try-1", "130"), std::pair("try-2", "3")}) {
    std::ifstream kept(scratch.path() / "kept" / name / "user-0.recording");
    std::string text;
    kept >> text;
    EXPECT_EQ(text, frames);
  }
}

TEST(TryLive, RunsASecondTimeIfTooManyFramesAreMissed) {
  for (const auto& [missed, count] : {std::pair(100U, 1), std::pair(101U, 2)}) {
    const ScratchFolder scratch;
    for (const std::filesystem::path& keep : {std::filesystem::path{}, scratch.path() / "kept"}) {
      const Result<LiveTries> tries = TryLive(keep, [&](const std::filesystem::path& folder) {
        return Record(folder, missed);
      });
      ASSERT_TRUE(tries) << tries.error().what;
      EXPECT_EQ(tries->count, count);
      EXPECT_EQ(tries->last.missed, missed);
    }
  }
}

TEST(TryLive, ReportsTheErrorOfAnAttempt) {
  const Result<LiveTries> tries = TryLive({}, [](const std::filesystem::path&) -> Result<LiveRun> {
    return Error{"a peer ended with exit code 3"};
  });
  ASSERT_FALSE(tries);
  EXPECT_EQ(tries.error().what, "a peer ended with exit code 3");
}

const ComparedFigure& Judged(const char* name) {
  for (const ComparedFigure& figure : ComparedFigures()) {
    if (std::string(figure.name) == name) {
      EXPECT_TRUE(figure.judged);
      return figure;
    }
  }
  ADD_FAILURE() << name;
  return ComparedFigures().front();
}

TEST(LiveComparison, IsRelativeToVirtualTime) {
  Metrics live;
  Metrics virtual_time;
  live.peak_apart = 0.045;
  virtual_time.peak_apart = 0.05;
  EXPECT_NEAR(DeviationOf(Judged("divergence at the most"), live, virtual_time), -0.1, 1e-12);
}

// Where virtual time has nothing at all, a tenth of a millimetre and a hundredth of a newton stand
// for it. So a shaking run is within no bar of up to ten, and a rounding is within each.
TEST(LiveComparison, ExplosionNeverMatchesRest) {
  Metrics live;
  const Metrics rest;
  EXPECT_EQ(DeviationOf(Judged("divergence at the most"), live, rest), 0.0);
  live.peak_apart = 0.5;
  live.peak_force = 5;
  EXPECT_GT(DeviationOf(Judged("divergence at the most"), live, rest), 10.0);
  EXPECT_GT(DeviationOf(Judged("hand's force at the most"), live, rest), 10.0);
  live.peak_apart = 1e-9;
  EXPECT_LT(DeviationOf(Judged("divergence at the most"), live, rest), 1e-4);
  live.peak_apart = std::nan("");
  EXPECT_EQ(DeviationOf(Judged("divergence at the most"), live, rest),
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace tandem
