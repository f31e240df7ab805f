#include "collab/trace/path_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

constexpr PeerId kWe = 1;
constexpr PeerId kHeardPeer = 2;

/// Two peers with frames of 1 ms that send in each. The session is a model of its own of what we
/// hear. All times are in ms of our clock; the other's is `offset` ahead.
struct Session {
  int there_ms = 30;
  int back_ms = 30;
  std::int64_t offset_ms = 5'000'000;
  int frames = 3000;
  int every = 1;           // the other sends in frames that this divides
  int lost_back_each = 0;  // 0: none
  bool echoes = true;
  int pause_from = -1;  // no states for 3 s

  PathEstimator Heard() const {
    PathEstimator line(kWe);
    for (int now = 0; now < frames; ++now) {
      const int sent = now - back_ms;  // when the message of this frame was sent
      if (sent < 0 || sent % every != 0) continue;
      if (lost_back_each > 0 && (sent / every) % lost_back_each == 4) continue;
      if (pause_from >= 0 && sent >= pause_from && sent < pause_from + 3000) continue;
      const std::int64_t stamp = (sent + offset_ms) * kMs;
      ObjectState state;
      state.peer = kHeardPeer;
      state.seq = static_cast<std::uint32_t>(100 + sent);
      state.sample_ns = stamp;
      line.Add(state, now * kMs);
      CouplingLinks links;
      links.from = kHeardPeer;
      links.seq = state.seq;
      links.sample_ns = stamp;
      links.count = 1;
      links.entries[0].to = kWe;
      links.entries[0].echo_ns = echoes && sent > there_ms ? (sent - there_ms) * kMs : 0;
      line.Add(links);
    }
    return line;
  }
};

TEST(PathEstimator, EchoesGiveRoundTripAndRateForAnyClocks) {
  const std::optional<PathEstimator::Estimate> found = Session{}.Heard().EstimatePath();
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->has_echoes);
  EXPECT_DOUBLE_EQ(found->record.rate_hz, 1000);
  const ClockEstimate clocks = EstimateClocks(found->record);
  EXPECT_NEAR(clocks.bound_ms, 30, 0.01);
  EXPECT_NEAR(1e-6 * static_cast<double>(clocks.offset_ns), 5'000'000, 0.01);
  const NetworkTrace trace = TraceOf(found->record, clocks);
  EXPECT_NEAR(trace.there_ms[1000], 30, 0.01);
  EXPECT_NEAR(trace.back_ms[1000], 30, 0.01);
}

TEST(PathEstimator, AsymmetricLineHasTheRightRoundTrip) {
  const std::optional<PathEstimator::Estimate> found =
      Session{.there_ms = 10, .back_ms = 80}.Heard().EstimatePath();
  ASSERT_TRUE(found);
  const NetworkTrace trace = TraceOf(found->record, EstimateClocks(found->record));
  EXPECT_NEAR(trace.there_ms[1000] + trace.back_ms[1000], 90, 0.01);
}

TEST(PathEstimator, PacketLossIsExact) {
  const std::optional<PathEstimator::Estimate> found =
      Session{.lost_back_each = 10}.Heard().EstimatePath();
  ASSERT_TRUE(found);
  int lost = 0;
  for (std::size_t i = 0; i < found->record.back_ns.size(); ++i) {
    const bool never = found->record.back_ns[i] == PathRecord::kNever;
    EXPECT_EQ(never, i % 10 == 4) << i;
    lost += never ? 1 : 0;
  }
  EXPECT_EQ(lost, 294);  // a tenth of 2940: nobody tells of the last 30 of ours
}

// Our own 30 ms old samples reach the other in each frame, but it sends in each tenth. No echo
// tells of the rest.
TEST(PathEstimator, SlowerSenderHasItsOwnRate) {
  const std::optional<PathEstimator::Estimate> found = Session{.every = 10}.Heard().EstimatePath();
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->record.rate_hz, 100);
  EXPECT_EQ(std::ranges::count(found->record.back_ns, PathRecord::kNever), 0);
  const NetworkTrace trace = TraceOf(found->record, EstimateClocks(found->record));
  // its newest of ours is 30 ms old when it sends; the period in which it was sent may begin 9 ms
  // before
  const double sum = static_cast<double>(trace.there_ms[100]) + trace.back_ms[100];
  EXPECT_GE(sum, 60 - 0.01);
  EXPECT_LE(sum, 70);
}

TEST(PathEstimator, UsesTheLongestUninterruptedInterval) {
  const std::optional<PathEstimator::Estimate> found =
      Session{.frames = 9000, .pause_from = 1000}.Heard().EstimatePath();
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->seconds, 5, 0.1);
}

TEST(PathEstimator, WithoutEchoesOnlyTheReturnDelayIsKnown) {
  const std::optional<PathEstimator::Estimate> found =
      Session{.echoes = false}.Heard().EstimatePath();
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->has_echoes);
  EXPECT_FALSE(PathEstimator(kWe).EstimatePath());
}

}  // namespace
}  // namespace tandem
