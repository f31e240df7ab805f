#include "collab/lab/run/press_run.h"

#include <gtest/gtest.h>

#include "engine/contact/features/edge_contact.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

std::shared_ptr<const WorldModel> TwoBlocks() {
  const auto block = [](double x) {
    const Vec3 size(0.06, 0.06, 0.06);
    return Transformed(testing::Box(size), {Quat::Identity(), Vec3(x, 0, 0)});
  };
  return testing::MakeWorldModel({{block(-0.06)}, {block(0.06)}}, 0.002);
}

PressResult RunAt(PressMotion motion, MirrorModel mirror, double delay_ms, double seconds = 6) {
  static const std::shared_ptr<const WorldModel> kModel = TwoBlocks();
  PressCase test;
  test.motion = motion;
  test.mirror = mirror;
  test.conditions.delay_ms = delay_ms;
  test.seconds = seconds;
  const Result<PressResult> result = RunPress(test, kModel);
  return result ? *result : PressResult{};
}

// Hands of 300 N/m with 0.9 kg and the body's 0.3 kg swing once in 0.4 s, four delays of 100 ms:
// there a mirror that stands like a rock gives back in step what was pressed in.
TEST(PressRun, HeldMirrorsDestabilizeAtAPeriodOfFourDelays) {
  const PressResult held = RunAt(PressMotion::kPress, MirrorModel::kHeld, 100, 12);
  EXPECT_FALSE(held.calm);
  EXPECT_GT(held.unrest, 5e-3);
  const PressResult alone = RunAt(PressMotion::kPress, MirrorModel::kHeld, 0, 12);
  EXPECT_TRUE(alone.calm);
  EXPECT_LT(alone.unrest, 1e-4);
}

// Each hand is kept 20 mm from where it wants to be, half of the 40 mm of overlap and of the
// clearance at which contact begins, by its spring of 300 N/m and the 800 N/m between device and
// body, one after the other.
TEST(PressRun, UndelayedForceMatchesTheSprings) {
  // blocks without friction come to rest on one another slowly
  const PressResult result = RunAt(PressMotion::kPress, MirrorModel::kCompliantMirror, 0, 30);
  const double kept_back = 0.02 + 0.5 * kRefinedClearance * 0.002;
  EXPECT_NEAR(result.mean_force, 300.0 * 800.0 / 1100.0 * kept_back, 0.05);
}

TEST(PressRun, CompliantMirrorsAreStableAtEveryDelay) {
  for (const PressMotion motion : {PressMotion::kPress, PressMotion::kPush, PressMotion::kTap}) {
    for (const double delay_ms : {20.0, 100.0, 300.0}) {
      const PressResult result = RunAt(motion, MirrorModel::kCompliantMirror, delay_ms);
      EXPECT_TRUE(result.calm) << NameOf(motion) << ' ' << delay_ms;
      EXPECT_LT(result.peak_force, 12) << NameOf(motion) << ' ' << delay_ms;
    }
  }
}

// A predicted pose lies deeper in the other body than the received one, so energy comes in
// (docs/decisions/0028-live-and-type-1.md).
TEST(PressRun, DeadReckoningDestabilizesTapping) {
  EXPECT_FALSE(RunAt(PressMotion::kTap, MirrorModel::kDeadReckoned, 100).calm);
  EXPECT_TRUE(RunAt(PressMotion::kTap, MirrorModel::kHeld, 100).calm);
}

TEST(PressRun, IsDeterministic) {
  const PressResult once = RunAt(PressMotion::kPress, MirrorModel::kHeld, 100);
  const PressResult again = RunAt(PressMotion::kPress, MirrorModel::kHeld, 100);
  EXPECT_EQ(once.unrest, again.unrest);
  EXPECT_EQ(once.force_std, again.force_std);
  EXPECT_EQ(once.peak_force, again.peak_force);
}

}  // namespace
}  // namespace tandem
