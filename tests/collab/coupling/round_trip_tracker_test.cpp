#include "collab/coupling/round_trip_tracker.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

constexpr PeerId kSelf = 1;
constexpr PeerId kPartner = 2;

/// Runs our end of a loop to one other peer, frame by frame. Each of our stamps comes back
/// `loop_ms` after it went out, while the other answers.
class Bench {
 public:
  Bench() { Claims(true); }

  void Claims(bool holds) {
    MembershipChange change{.kind = MembershipChange::Kind::kClaims, .peer = kPartner};
    change.claim_count = 1;
    change.claims[0] = {.object = 7, .epoch = 1, .held = holds};
    echoes_.OnMembership(change);
  }
  void Leave() { echoes_.OnMembership({.kind = MembershipChange::Kind::kLost, .peer = kPartner}); }

  void Run(int frames, int loop_ms, bool holding = true, bool answers = true) {
    for (int i = 0; i < frames; ++i) {
      ++ms_;
      if (answers) Hear(ms_ - loop_ms);
      echoes_.Measure(ms_ * kMs, holding);
      CouplingLinks links;
      if (holding) echoes_.Append(ms_ * kMs, links);
    }
  }
  void Hear(std::int64_t stamp_ms) {
    CouplingLinks links;
    links.from = kPartner;
    links.seq = ++seq_;
    links.count = 1;
    links.entries[0].to = kSelf;
    links.entries[0].echo_ns = stamp_ms * kMs;
    echoes_.OnLinks(links);
  }
  RoundTripTracker::Loop loop() const { return echoes_.loops().front(); }
  std::size_t count() const { return echoes_.loops().size(); }
  std::int64_t ms() const { return ms_; }

 private:
  RoundTripTracker echoes_{kSelf};
  std::int64_t ms_ = 1000;
  std::uint32_t seq_ = 0;
};

TEST(RoundTripTracker, LoopAgeIsThatOfTheNewestEchoWithATwoSecondPeak) {
  Bench bench;
  bench.Run(500, 40);
  EXPECT_DOUBLE_EQ(bench.loop().age_s, 0.040);
  EXPECT_DOUBLE_EQ(bench.loop().peak_s, 0.040);
  bench.Run(500, 10);
  EXPECT_DOUBLE_EQ(bench.loop().age_s, 0.010);
  EXPECT_DOUBLE_EQ(bench.loop().peak_s, 0.040);
  bench.Run(1600, 10);
  EXPECT_DOUBLE_EQ(bench.loop().peak_s, 0.010);
}

// Until something has come back a loop is at least as old as we have waited for it.
TEST(RoundTripTracker, OpenLoopAgesWithTheWait) {
  Bench bench;
  bench.Run(300, 400);
  EXPECT_EQ(bench.loop().age_s, 0.0);
  EXPECT_NEAR(bench.loop().peak_s, 0.3, 0.002);
  bench.Run(300, 400);
  EXPECT_DOUBLE_EQ(bench.loop().age_s, 0.4);
  EXPECT_DOUBLE_EQ(bench.loop().peak_s, 0.4);
}

// A line that is cut while both hold grows older with the clock, on from the age that it had.
TEST(RoundTripTracker, SilentLoopAgesWhileBothPeersHold) {
  Bench bench;
  bench.Run(500, 20);
  bench.Run(5000, 20, true, false);
  EXPECT_NEAR(bench.loop().age_s, 5.02, 1e-9);
  EXPECT_NEAR(bench.loop().peak_s, 5.02, 1e-9);
  bench.Run(100, 20);
  EXPECT_DOUBLE_EQ(bench.loop().age_s, 0.020);
  EXPECT_NEAR(bench.loop().peak_s, 5.02, 1e-9);
  bench.Run(2000, 20);
  EXPECT_DOUBLE_EQ(bench.loop().peak_s, 0.020);
}

// An empty hand on either side: nothing comes back, for there is no loop.
TEST(RoundTripTracker, LoopEndsWhenEitherPeerReleases) {
  for (const bool ours : {true, false}) {
    SCOPED_TRACE(ours);
    Bench bench;
    bench.Run(500, 300);
    if (!ours) bench.Claims(false);
    bench.Run(1, 300, !ours, false);
    EXPECT_EQ(bench.loop().age_s, 0.0);
    EXPECT_EQ(bench.loop().peak_s, 0.0);
    bench.Run(57'000, 300, !ours, false);
    EXPECT_EQ(bench.loop().peak_s, 0.0);
    // taken up again a minute later: nothing of that pause is in its age
    bench.Claims(true);
    bench.Run(10, 20, true, false);
    EXPECT_EQ(bench.loop().age_s, 0.0);
    EXPECT_NEAR(bench.loop().peak_s, 0.010, 0.002);
    bench.Run(500, 20);
    EXPECT_DOUBLE_EQ(bench.loop().age_s, 0.020);
    EXPECT_DOUBLE_EQ(bench.loop().peak_s, 0.020);
  }
}

// A peer that takes something else at once keeps what was known of the line.
TEST(RoundTripTracker, PeakLastsTwoSecondsBeyondTheLoop) {
  Bench bench;
  bench.Run(500, 300);
  bench.Run(200, 300, false, false);
  bench.Run(10, 300, true, false);
  EXPECT_EQ(bench.loop().age_s, 0.0);
  EXPECT_DOUBLE_EQ(bench.loop().peak_s, 0.3);
}

// The other peer goes on telling the last stamp that it has of us, which is as old as our pause.
TEST(RoundTripTracker, TimestampsOfAnEarlierGraspAreIgnored) {
  Bench bench;
  bench.Run(500, 20);
  const std::int64_t last = bench.ms();
  bench.Run(3000, 20, false, false);
  bench.Run(5, 20, true, false);
  bench.Hear(last);
  bench.Run(1, 20, true, false);
  EXPECT_EQ(bench.loop().age_s, 0.0);
}

TEST(RoundTripTracker, DepartedPeerHasNoLoop) {
  Bench bench;
  bench.Run(500, 20);
  EXPECT_EQ(bench.count(), 1U);
  bench.Leave();
  bench.Run(1, 20);
  EXPECT_EQ(bench.count(), 0U);
}

}  // namespace
}  // namespace tandem
