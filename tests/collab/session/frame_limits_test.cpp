#include "collab/session/frame_limits.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(FrameLimits, AreSharesOfAllFramesAndTheLastSecond) {
  FrameLimitCount count;
  for (int frame = 0; frame < 2000; ++frame) {
    std::uint32_t flags = 0;
    if (frame < 1000 && frame % 4 == 0) flags |= StepReport::kTravelLimited;
    if (frame % 100 == 0) flags |= StepReport::kOverCapacity;
    if (frame >= 1000 && frame % 2 == 0) flags |= StepReport::kContactsFull;
    if (frame >= 1995) flags |= StepReport::kWaitsForVoxels;
    count.Count(flags);
    if (frame == 998) {
      EXPECT_EQ(count.last(), FrameLimits{});
    }
    if (frame == 999) {
      EXPECT_EQ(count.last(), (FrameLimits{0.25, 0.01, 0}));
    }
  }
  EXPECT_EQ(count.last(), (FrameLimits{0, 0.01, 0.5, 0.005}));
  EXPECT_EQ(count.all(), (FrameLimits{0.125, 0.01, 0.25, 0.0025}));
}

// Limits stand beside the bits that flags are for, and no flag is mistaken for them.
TEST(FrameLimits, TravelInFlagsToAPercent) {
  const FrameLimits limits{.travel_limited = 1, .over_capacity = 0.374, .contacts_full = 1e-3};
  const std::uint32_t flags = AsFlags(limits);
  const std::uint32_t state = StepReport::kTravelLimited | StepReport::kOverCapacity |
                              StepReport::kContactsFull | kStateParked | kStateLoose;
  const std::uint32_t view = ViewBody::kHeld | ViewBody::kInContact | ViewBody::kTrapped;
  EXPECT_EQ(flags & (state | view), 0U);
  const FrameLimits reported{.travel_limited = 1, .over_capacity = 0.37, .contacts_full = 0.01};
  EXPECT_EQ(LimitsIn(flags | state), reported);
  EXPECT_EQ(LimitsIn(flags | view), reported);
  EXPECT_EQ(AsFlags({}), 0U);
  EXPECT_EQ(LimitsIn(state), FrameLimits{});
  // every number that comes over the network gives shares
  EXPECT_EQ(LimitsIn(0xFFFFFFFF), (FrameLimits{1, 1, 1, 0.01}));
  // flags tell only whether there was any waiting
  EXPECT_EQ(LimitsIn(AsFlags({.waited = 0.3}) | state), (FrameLimits{.waited = 0.01}));
}

TEST(FrameLimits, ConcernTheHeldBody) {
  const FrameLimits limits{.travel_limited = 0.5, .over_capacity = 0, .contacts_full = 0};
  const ViewBody parked{.object = 1, .flags = 0, .X_W = {}, .hand_force_W = Vec3::Zero()};
  ViewBody held = parked;
  held.flags = ViewBody::kHeld | AsFlags(limits);
  EXPECT_EQ(LimitsOf({parked, held}), limits);
  EXPECT_EQ(LimitsOf({parked}), FrameLimits{});
}

TEST(FrameLimits, AreReportedOnlyIfPresent) {
  EXPECT_EQ(AsText({}), "");
  EXPECT_TRUE(Explain({}).empty());
  const FrameLimits limits{.travel_limited = 0.12, .over_capacity = 0.002, .contacts_full = 0};
  EXPECT_EQ(AsText(limits), "slowed 12 %, over capacity 0.2 %");
  EXPECT_EQ(Explain(limits).size(), 2U);
  EXPECT_EQ(AsText({.waited = 0.02}), "waits for voxels");
  EXPECT_EQ(Explain({.waited = 0.02}).size(), 1U);
}

}  // namespace
}  // namespace tandem
