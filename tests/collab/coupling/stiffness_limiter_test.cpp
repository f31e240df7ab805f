#include "collab/coupling/stiffness_limiter.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kHands = 300;      // N/m, of each of two hands
constexpr double kHeldApart = 0.1;  // m; from where one hand means to be to where the other does

/// Returns where one instance of a part is that two hands hold apart, at rest, when the link has
/// stiffness k. By statics: kHands x = k d, d = kHeldApart - 2 x.
double PlaceAt(double k) {
  return kHeldApart * k / (kHands + 2.0 * k);
}

/// Returns the fastest motion of an instance while the link follows what the delay allows, m/s.
template <class Allowed>
double FastestMotion(double k, double seconds, const Allowed& allowed) {
  constexpr double kFrame = 1e-3;
  double fastest = 0;
  double speed = 0;
  for (int i = 0; i < static_cast<int>(seconds / kFrame); ++i) {
    const double limit = allowed(kFrame * i);
    const double before = PlaceAt(k);
    StiffnessLimiter slew{.h = kFrame,
                          .stretch = kHeldApart - 2.0 * before,
                          .ceiling = limit,
                          .wanted = limit,
                          .room = 1e9,
                          .speed = speed,
                          .falls_unfelt = true,
                          .rises_unfelt = true};
    k = slew.Next(k);
    speed = std::abs(PlaceAt(k) - before) / kFrame;
    fastest = std::max(fastest, speed);
  }
  return fastest;
}

// A network that moves its delay up and down by half moves a part that hands pull apart, slowly and
// unfelt. Among eight users 0.17 mm/s each make 0.5 mm/s.
TEST(StiffnessLimiter, VaryingDelayIsNotFeltByOpposingHands) {
  const double fastest = FastestMotion(130, 60, [](double t_s) {
    return std::fmod(t_s, 2.0) < 0.4 ? 90.0 : 140.0;
  });
  EXPECT_GT(fastest, 1e-6);
  EXPECT_LT(fastest, 0.17e-3);
}

StiffnessLimiter Unfelt(double stretch, double allowed, double speed) {
  return {.stretch = stretch,
          .ceiling = allowed,
          .wanted = allowed,
          .room = 1e9,
          .speed = speed,
          .falls_unfelt = true,
          .rises_unfelt = true};
}

double After(const StiffnessLimiter& slew, double k, int frames) {
  for (int i = 0; i < frames; ++i) k = slew.Next(k);
  return k;
}

TEST(StiffnessLimiter, FallsAtOnceForAMovingPart) {
  EXPECT_NEAR(After(Unfelt(0.03, 40, 0.05), 60, 100), 40, 0.5);
  EXPECT_GT(After(Unfelt(0.03, 40, 0), 60, 100), 59.9);
}

TEST(StiffnessLimiter, FallsAtOnceFromFarAboveTheLimit) {
  const double fallen = After(Unfelt(0.02, 40, 0), 400, 300);
  EXPECT_LT(fallen, 240);
  EXPECT_GE(fallen, 40);
}

// A spring that is not stretched moves nothing when its stiffness changes.
TEST(StiffnessLimiter, FollowsTheDelayAtOnceAtZeroForce) {
  EXPECT_NEAR(After(Unfelt(0, 40, 0), 60, 200), 40, 0.1);
  EXPECT_NEAR(After(Unfelt(0, 100, 0), 40, 400), 100, 0.1);
}

TEST(StiffnessLimiter, FallsAtOnceForCausesOtherThanDelay) {
  StiffnessLimiter slew = Unfelt(0.03, 40, 0);
  slew.falls_unfelt = false;
  EXPECT_NEAR(After(slew, 60, 100), 40, 0.5);
}

}  // namespace
}  // namespace tandem
