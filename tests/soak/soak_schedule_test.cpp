#include "tests/soak/soak_schedule.h"

#include <set>

#include <gtest/gtest.h>

namespace tandem::testing {
namespace {

std::string Drawn(std::uint64_t seed, int count) {
  SoakSchedule schedule(seed);
  std::string text;
  for (int i = 0; i < count; ++i) text += AsJson(schedule.Next()).dump();
  return text;
}

TEST(SoakSchedule, FaultsAreDeterministicPerSeed) {
  EXPECT_EQ(Drawn(7, 100), Drawn(7, 100));
  EXPECT_NE(Drawn(7, 100), Drawn(8, 100));
}

TEST(SoakSchedule, EveryRoundHasEveryKindOnce) {
  SoakSchedule schedule(1);
  for (int round = 0; round < 50; ++round) {
    std::set<SoakFault::Kind> kinds;
    for (std::size_t i = 0; i < SoakFault::kKinds; ++i) kinds.insert(schedule.Next().kind);
    EXPECT_EQ(kinds.size(), SoakFault::kKinds);
  }
}

TEST(SoakSchedule, DrawsOnlyNamedKinds) {
  SoakSchedule schedule(1, KindsIn("stop,clock_step"));
  std::set<SoakFault::Kind> kinds;
  for (int i = 0; i < 20; ++i) kinds.insert(schedule.Next().kind);
  EXPECT_EQ(kinds,
            (std::set<SoakFault::Kind>{SoakFault::Kind::kStop, SoakFault::Kind::kClockStep}));
}

// Their memory is judged over the whole run.
TEST(SoakSchedule, FirstPeerAndFirstViewerAreNeverKilled) {
  SoakSchedule schedule(1);
  std::set<std::size_t> ended;
  for (int i = 0; i < 1000; ++i) {
    const SoakFault fault = schedule.Next();
    if (fault.kind == SoakFault::Kind::kKill || fault.kind == SoakFault::Kind::kFullDisk) {
      ended.insert(fault.place);
    }
    if (fault.kind == SoakFault::Kind::kStop) {
      EXPECT_GE(fault.lasts_s, 0.2);
      EXPECT_LE(fault.lasts_s, 5.0);
    }
  }
  EXPECT_EQ(ended, (std::set<std::size_t>{1, 2, SoakPlaces::kPeers + 1}));
}

}  // namespace
}  // namespace tandem::testing
