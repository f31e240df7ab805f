#include "collab/lab/metrics/metrics.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/world/world.h"

namespace tandem {
namespace {

constexpr double kTau = 0.1;

Inertia LightCube() {
  return {0.3, 8e-5 * Mat3::Identity()};
}

/// Two users whose instances move along x, and turn about z, as functions of time say.
struct Motion {
  double (*x)(double);
  double (*v)(double);
};

std::vector<UserFrame> At(const Motion& motion, double t) {
  std::vector<UserFrame> users(2);
  for (const double side : {1.0, -1.0}) {
    UserFrame& user = users[side > 0 ? 0 : 1];
    user.present = true;
    user.state.X_WB.p.x() = 0.5 * side * motion.x(t);
    user.state.V_WB.v.x() = 0.5 * side * motion.v(t);
  }
  return users;
}

Metrics Watch(const Motion& motion, double seconds, double judged_from_s = 0) {
  Meter meter(LightCube(), kTau, judged_from_s);
  const int frames = static_cast<int>(std::lround(seconds / kFrame));
  for (int i = 0; i < frames; ++i) meter.See(At(motion, kFrame * i));
  return meter.Finish();
}

// 1 Hz, growing by e in 2 s; RMS of 1/sqrt(2) of the amplitude, both users' squares summed.
TEST(Meter, MeasuresTheGrowthOfAnOscillation) {
  const Motion swing{[](double t) {
                       return 1e-5 * std::exp(0.5 * t) * std::sin(2 * M_PI * t);
                     },
                     [](double t) {
                       return 1e-4 * std::exp(0.5 * t) * std::sin(2 * M_PI * t);
                     }};
  const Metrics metrics = Watch(swing, 12);
  EXPECT_NEAR(metrics.growth, 0.5, 0.02);
  EXPECT_EQ(metrics.windows, 31);  // 8 s, half a second each, by a quarter
  EXPECT_EQ(Judge(metrics), Verdict::kUnstable);
  // mean of exp(t) over the last 1.2 s: exp(12) (1 - exp(-1.2)) / 1.2
  const double mean = std::exp(12.0) * (1 - std::exp(-1.2)) / 1.2;
  EXPECT_NEAR(metrics.tail_rms, 1e-4 * 0.5 * std::sqrt(mean), 0.05 * metrics.tail_rms);
}

TEST(Meter, DecayingOscillationIsStable) {
  const Motion swing{[](double t) {
                       return 1e-3 * std::exp(-0.05 * t) * std::sin(6 * t);
                     },
                     [](double t) {
                       return 1e-3 * std::exp(-0.05 * t) * std::cos(6 * t);
                     }};
  const Metrics metrics = Watch(swing, 12);
  EXPECT_LT(metrics.growth, 0);
  EXPECT_EQ(Judge(metrics), Verdict::kStable);
}

// It does not grow, but neither is it at rest.
TEST(Meter, SustainedOscillationIsUnstable) {
  const Motion swing{[](double t) {
                       return 1e-2 * std::sin(6 * t);
                     },
                     [](double t) {
                       return 6e-2 * std::exp(-1e-3 * t) * std::cos(6 * t);
                     }};
  EXPECT_EQ(Judge(Watch(swing, 12)), Verdict::kUnstable);
}

// 100 mm/s each that fall by e in 3.3 s: 3.4 mm/s are left after 12 s, and nothing after 48 s.
TEST(Meter, UnsettledDecayIsUndecidedAndNeedsTime) {
  const Motion swing{[](double t) {
                       return 0.04 * std::exp(-0.3 * t) * std::sin(6 * t);
                     },
                     [](double t) {
                       return 0.2 * std::exp(-0.3 * t) * std::cos(6 * t);
                     }};
  const Metrics early = Watch(swing, 12);
  EXPECT_NEAR(early.growth, -0.3, 0.02);
  EXPECT_GT(early.tail_rms, 2e-3);
  EXPECT_EQ(Judge(early), Verdict::kUndecided);
  EXPECT_TRUE(DecaysAboveRest(early));
  const Metrics late = Watch(swing, 48);
  EXPECT_EQ(Judge(late), Verdict::kStable);
  EXPECT_FALSE(DecaysAboveRest(late));
}

// A swing at its limits has some growth that is not zero: it is no decay unless it halves.
TEST(Meter, BarelyDecayingOscillationIsNotUndecided) {
  const Motion swing{[](double t) {
                       return 0.02 * std::exp(-0.02 * t) * std::sin(6 * t);
                     },
                     [](double t) {
                       return 0.1 * std::exp(-0.02 * t) * std::cos(6 * t);
                     }};
  const Metrics metrics = Watch(swing, 12);
  EXPECT_TRUE(DecaysAboveRest(metrics));
  EXPECT_EQ(Judge(metrics), Verdict::kUnstable);
}

TEST(Meter, TooFewWindowsAreUndecided) {
  const Motion rest{[](double) {
                      return 0.0;
                    },
                    [](double) {
                      return 0.0;
                    }};
  EXPECT_EQ(Judge(Watch(rest, 1.5)), Verdict::kUndecided);
}

TEST(Meter, HalfAMetreApartIsAnExplosion) {
  const Motion apart{[](double t) {
                       return t;
                     },
                     [](double) {
                       return 1.0;
                     }};
  const Metrics metrics = Watch(apart, 0.6);
  EXPECT_TRUE(metrics.diverged);
  EXPECT_EQ(Judge(metrics), Verdict::kUnstable);
}

// A distance of 10 mm that fades with a time constant of 1 s is within 2 mm after ln 5 s.
TEST(Meter, ReportsSettling) {
  const Motion fades{[](double t) {
                       return t < 2 ? 0.01 : 0.01 * std::exp(-(t - 2));
                     },
                     [](double) {
                       return 0.0;
                     }};
  const Metrics metrics = Watch(fades, 14, 2);
  EXPECT_NEAR(metrics.settle_s, std::log(5.0), 0.1);
  EXPECT_NEAR(metrics.peak_apart, 0.01, 1e-12);
  EXPECT_LT(metrics.last_apart, 1e-6);
}

// 1 Hz is in the lower band, 30 Hz in the upper: an amplitude of 1 gives an RMS of 0.707.
TEST(Meter, DistinguishesSlowOscillationFromBuzzing) {
  const Motion slow{[](double) {
                      return 0.0;
                    },
                    [](double t) {
                      return 1e-3 * std::sin(2 * M_PI * t);
                    }};
  const Motion buzz{[](double) {
                      return 0.0;
                    },
                    [](double t) {
                      return 1e-3 * std::sin(60 * M_PI * t);
                    }};
  EXPECT_NEAR(Watch(slow, 20, 5).band_low_rms, 0.707e-3, 0.05e-3);
  EXPECT_LT(Watch(slow, 20, 5).band_high_rms, 0.05e-3);
  EXPECT_NEAR(Watch(buzz, 20, 5).band_high_rms, 0.707e-3, 0.05e-3);
  EXPECT_LT(Watch(buzz, 20, 5).band_low_rms, 0.05e-3);
}

// A force of 2 N along a motion of 0.1 m/s gives 0.2 W; a drag of 5 N s/m takes 0.05 W of it. A
// moment of 0.01 N m on a turn of 3 rad/s gives 0.03 W, and the drag takes 5 x 9 x I/m.
TEST(Meter, EnergyBalanceIncludesRotation) {
  Meter meter(LightCube(), kTau, 0);
  std::vector<UserFrame> users(2);
  users[0].present = true;
  users[0].state.V_WB = {Vec3(0, 0, 3), Vec3(0.1, 0, 0)};
  users[0].ground_damping = 5;
  users[0].link_count = 1;
  users[0].links_B_W[0] = {Vec3(0, 0, 0.01), Vec3(2, 0, 0)};
  for (int i = 0; i < 1000; ++i) meter.SeeOpening(users);
  for (int i = 0; i < 1000; ++i) meter.See(users);
  const double power = 0.2 - 0.05 + 0.03 - 5 * 9 * 8e-5 / 0.3;
  EXPECT_NEAR(meter.Finish().generated_J, 2 * power, 1e-9);
  // energy taken later does not undo it
  users[0].links_B_W[0].f.x() = -2;
  for (int i = 0; i < 5000; ++i) meter.See(users);
  EXPECT_NEAR(meter.Finish().generated_J, 2 * power, 1e-9);
}

TEST(Meter, MeasuresForcesRatesAndLimits) {
  Meter meter(LightCube(), kTau, 0);
  std::vector<UserFrame> users(2);
  users[0].present = users[1].present = true;
  users[0].link_count = 1;
  for (int i = 0; i < 100; ++i) {
    users[0].felt_W.f = Vec3(0, i < 50 ? 1 : 3, 0);
    users[0].links_B_W[0].f = Vec3(i < 50 ? 1 : 1.5, 0, 0);
    users[0].links[0].stiffness = 200;
    users[0].links[0].loop_age_s = 0.2;
    users[0].links[0].clipped = i >= 90;
    users[1].guarded_frames += i >= 80 ? 1 : 0;
    users[1].trapped = i < 7;
    meter.See(users);
  }
  const Metrics metrics = meter.Finish();
  EXPECT_DOUBLE_EQ(metrics.peak_force, 3);
  EXPECT_NEAR(metrics.peak_force_rate, 2000, 1e-6);
  EXPECT_DOUBLE_EQ(metrics.link_force, 1.5);
  EXPECT_NEAR(metrics.link_force_rate, 500, 1e-6);
  EXPECT_NEAR(metrics.clip_share, 10.0 / 200, 1e-12);
  EXPECT_NEAR(metrics.guarded_share, 20.0 / 200, 1e-12);
  EXPECT_DOUBLE_EQ(metrics.stiffness, 200);
  EXPECT_DOUBLE_EQ(metrics.loop_age_s, 0.2);
  EXPECT_EQ(metrics.trapped_frames, 7);
}

}  // namespace
}  // namespace tandem
