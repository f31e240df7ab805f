// Tests a vendor's thread that asks and a loop that puts, in virtual time and in one thread.
#include "engine/safety/vendor_mailbox.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

/// A loop of a kilohertz, and a thread that asks `asks` times a millisecond.
struct Asking {
  explicit Asking(int a_ms = 4) : asks(a_ms) { wanted.f.x() = 5; }
  /// Runs a millisecond, in which the loop puts or stands still.
  void Run(bool puts = true) {
    if (puts) mailbox.Put(wanted, now_ns);
    for (int i = 0; i < asks; ++i) {
      now_ns += kMs / asks;
      const Wrench before = given;
      given = mailbox.Take(now_ns);
      if (!given.f.isZero()) step = std::max(step, (given.f - before.f).norm());
      most = std::max(most, given.f.norm());
    }
  }
  void Run(int ms, bool puts) {
    for (int i = 0; i < ms; ++i) Run(puts);
  }
  VendorMailbox mailbox{DeviceLimits{.force = 12, .moment = 0.5}};
  std::int64_t now_ns = 1000 * kMs;
  int asks;
  Wrench wanted, given;
  double step = 0, most = 0;
};

TEST(VendorMailbox, DeliversTheLatestForce) {
  for (const int asks : {1, 4}) {
    Asking rig(asks);
    rig.Run(5, false);
    EXPECT_TRUE(rig.given.f.isZero());
    rig.Run(1100, true);
    EXPECT_NEAR(rig.given.f.x(), 5, 1e-9);
    // two newtons a millisecond
    EXPECT_LE(rig.step, 2.0 / asks + 1e-9);
    EXPECT_LE(rig.mailbox.most_age_ns(), kMs / asks);
  }
}

TEST(VendorMailbox, StaleForceFadesAfter5MillisecondsAndEndsAfter20) {
  for (const double force : {5.0, 12.0}) {
    Asking rig;
    rig.wanted.f.x() = force;
    rig.Run(1100, true);
    rig.Run(4, false);  // five old at its end, for it was put a millisecond before
    for (int age = 6; age <= 40; ++age) {
      rig.Run(1, false);
      EXPECT_LE(rig.given.f.x(), std::max(0.0, force - 2.0 * (age - 6))) << age;
      if (age >= 20) {
        EXPECT_TRUE(rig.given.f.isZero()) << age;
      }
    }
    EXPECT_LE(rig.step, 0.5 + 1e-9);
    // and it comes back slowly
    rig.Run(500, true);
    EXPECT_NEAR(rig.given.f.x(), 0.5 * force, 0.02 * force);
    rig.Run(520, true);
    EXPECT_NEAR(rig.given.f.x(), force, 1e-9);
  }
}

TEST(VendorMailbox, ShortStallCausesOneShortRamp) {
  Asking rig;
  rig.Run(1100, true);
  rig.Run(9, false);
  rig.Run(50, true);
  EXPECT_NEAR(rig.given.f.x(), 2.5, 0.1);
  rig.Run(60, true);
  EXPECT_NEAR(rig.given.f.x(), 5, 1e-9);
  Asking young;
  young.Run(100, true);
  young.Run(9, false);
  young.Run(200, true);
  EXPECT_LE(young.given.f.x(), 5 * 0.31);
}

TEST(VendorMailbox, CutHoldsUntilTheNextForce) {
  Asking rig;
  rig.Run(1100, true);
  rig.mailbox.Cut();
  rig.Run(3, false);  // an order put a millisecond ago counts no more
  EXPECT_TRUE(rig.given.f.isZero());
  rig.Run(100, true);
  EXPECT_NEAR(rig.given.f.x(), 0.5, 0.02);
}

TEST(VendorMailbox, StalledReaderGetsNoForceAtFirst) {
  Asking rig;
  rig.Run(1100, true);
  rig.now_ns += 30 * kMs;
  rig.mailbox.Put(rig.wanted, rig.now_ns);
  EXPECT_TRUE(rig.mailbox.Take(rig.now_ns + kMs / 10).f.isZero());
}

TEST(VendorMailbox, NeverDeliversNonFiniteOrExcessiveForces) {
  Asking rig;
  rig.Run(1100, true);
  rig.wanted.f.x() = 100;
  rig.Run(20, true);
  EXPECT_NEAR(rig.given.f.x(), 12, 1e-9);
  rig.wanted.f.y() = std::numeric_limits<double>::quiet_NaN();
  rig.Run(1, true);
  EXPECT_TRUE(rig.given.f.isZero());
  EXPECT_LE(rig.most, 12 + 1e-9);
}

}  // namespace
}  // namespace tandem
