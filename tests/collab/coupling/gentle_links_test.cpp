#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/collab/coupling/link_bench.h"

// Tests that a link takes force from a hand, or gives it, gently, whatever becomes of the partner.

namespace tandem {
namespace {

using testing::kOther;
using testing::LinkBench;

// A link of 400 N/m stretched by 7.5 mm pulls with 3 N. Its partner falls silent and is then told
// to be lost, or a third peer comes. The force falls by at most 1 N within 100 ms.
TEST(GentleLinks, PullOfThreeNewtonsFadesGently) {
  for (const bool third_comes : {false, true}) {
    SCOPED_TRACE(third_comes);
    LinkBench bench;
    bench.body.Join(kOther);
    for (int i = 0; i < 4000; ++i) bench.Frame(0.0075, 4, 500);
    ASSERT_NEAR(bench.stiffness(), 400, 1);
    if (third_comes) bench.body.Join(3);
    std::vector<double> force;
    for (int i = 0; i < 1500; ++i) {
      if (!third_comes && i == 600) bench.body.Part(kOther);
      if (third_comes) bench.Hear(3, 0.0, 4, 500);
      bench.Frame(0.0075, 4, 500, third_comes);
      force.push_back(0.0075 * bench.stiffness());
    }
    for (std::size_t i = 100; i < force.size(); ++i) {
      EXPECT_LE(force[i - 100] - force[i], 0.85) << i;
    }
    EXPECT_NEAR(force.back(), third_comes ? 1.5 : 0.0, 0.01);
  }
}

// A spring of 20 mm that pulls with 5 N falls by 10 N/s to 3 N when it is capped, and tells its
// partner so.
TEST(GentleLinks, CappedLinkFallsGentlyToItsCap) {
  LinkBench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 10000; ++i) bench.Frame(0.02, 2, 1e3);
  const double free = 0.02 * bench.stiffness();
  ASSERT_GT(free, 4.9);
  bench.body.CapForce(kOther, 3.0);
  double last = free;
  double fastest = 0;
  for (int i = 0; i < 2000; ++i) {
    bench.Frame(0.02, 2, 1e3);
    const double force = 0.02 * bench.stiffness();
    fastest = std::max(fastest, last - force);
    last = force;
  }
  EXPECT_NEAR(last, 3.0, 0.01);
  EXPECT_LT(fastest, 0.0101);
  EXPECT_NEAR(bench.out.entries[0].stiffness, bench.stiffness(), 0.1);
}

// A partner that we hear and that does not hear us tells the same echo again and again: that is
// silence, not a delay that grows, whose fall would take 20 ms.
TEST(GentleLinks, RepeatedEchoDoesNotIncreaseDelay) {
  constexpr double kStretch = 0.02;
  LinkBench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 10000; ++i) bench.Frame(kStretch, 40, 1e3);
  double last = kStretch * bench.stiffness();
  ASSERT_GT(last, 2.0);
  for (int i = 1; i <= 200; ++i) {
    bench.Frame(kStretch, 40 + i, 1e3);
    const double force = kStretch * bench.stiffness();
    EXPECT_LE(last - force, 0.00801) << i;
    last = force;
  }
}

/// Returns the force of all links along x, N, where each is stretched by so much.
double PullOf(const LinkBench& bench, double stretch) {
  double sum = 0;
  for (std::size_t i = 0; i < bench.inputs.link_count; ++i) {
    sum += stretch * bench.inputs.links[i].gains.stiffness;
  }
  return sum;
}

// Four links at once fall silent, are capped, or want next to nothing. Together they take no more
// than one may.
TEST(GentleLinks, SimultaneousFallsShareTheForceRateLimit) {
  constexpr double kStretch = 0.02;
  for (const bool capped : {false, true}) {
    SCOPED_TRACE(capped);
    LinkBench bench;
    for (PeerId peer = 2; peer < 6; ++peer) bench.body.Join(peer);
    const auto hear_all = [&] {
      for (PeerId peer = 2; peer < 6; ++peer) bench.Hear(peer, kStretch, 2, 1e3);
    };
    for (int i = 0; i < 20000; ++i) {
      hear_all();
      bench.Alone();
    }
    const double before = PullOf(bench, kStretch);
    ASSERT_GT(before, 4.0);
    for (PeerId peer = 2; capped && peer < 6; ++peer) bench.body.CapForce(peer, 0.3);
    std::vector<double> pull{before};
    for (int i = 0; i < 6000; ++i) {
      if (capped) hear_all();
      for (PeerId peer = 2; !capped && i == 600 && peer < 6; ++peer) bench.body.Part(peer);
      bench.Alone();
      pull.push_back(PullOf(bench, kStretch));
    }
    // the first frame of a fall does not know yet that others fall as well
    const double most = (capped ? 1.0 : 0.8) + 4 * 0.010;
    for (std::size_t i = 100; i < pull.size(); ++i) EXPECT_LE(pull[i - 100] - pull[i], most) << i;
    EXPECT_NEAR(pull.back(), capped ? 1.2 : 0.0, 0.02) << "none starves";
  }
}

// The peak of a loop of 600 ms is forgotten after two seconds of 40 ms. The drags then fall by 10 N
// s/m in a tenth of a second, not in a frame.
TEST(GentleLinks, DampingFallsGentlyWhenALoopShortens) {
  LinkBench bench({*MakeLaw("p+dd"), {.energy_gate = false}});
  bench.body.Join(kOther);
  for (int i = 0; i < 4000; ++i) bench.Frame(0, 600, 1e3);
  double link = bench.inputs.links[0].gains.damping;
  double ground = bench.inputs.ground_damping;
  EXPECT_NEAR(link, (*MakeLaw("p+dd"))->Link(LawInputsAt(0.6, 2, 1.5)).relative_damping, 1e-9);
  EXPECT_GT(ground, 7);
  double least_link = link;
  for (int i = 0; i < 4000; ++i) {
    bench.Frame(0, 40, 1e3);
    EXPECT_LE(link - bench.inputs.links[0].gains.damping, 0.1 + 1e-9) << i;
    EXPECT_LE(ground - bench.inputs.ground_damping, 0.1 + 1e-9) << i;
    link = bench.inputs.links[0].gains.damping;
    ground = bench.inputs.ground_damping;
    least_link = std::min(least_link, link);
  }
  EXPECT_LT(least_link, 3);
  EXPECT_LT(ground, 6);
}

// A sample that comes late shows another place and another speed. Both together change the force by
// 0.8 N a frame, and in the end by all of it.
TEST(GentleLinks, SamplesObeyTheForceRateLimit) {
  LinkBench bench({*MakeLaw("p+dd"), {.energy_gate = false}});
  bench.body.Join(kOther);
  for (int i = 0; i < 4000; ++i) bench.Frame(0, 100, 1e3);
  ASSERT_GT(bench.inputs.links[0].gains.damping, 5.0);
  const auto force = [&bench] {
    const StepInputs::Link& link = bench.inputs.links[0];
    return link.gains.stiffness * link.copy.X_WA.p.x() + link.gains.damping * link.copy.V_WA.v.x();
  };
  bench.its_speed = 0.3;
  double last = force();
  double most = 0;
  for (int i = 0; i < 50; ++i) {
    bench.Frame(0.02, 100, 1e3);
    most = std::max(most, std::abs(force() - last));
    last = force();
  }
  EXPECT_NEAR(most, 0.8, 0.01);
  EXPECT_NEAR(bench.inputs.links[0].copy.V_WA.v.x(), 0.3, 1e-12);
  EXPECT_NEAR(bench.inputs.links[0].copy.X_WA.p.x(), 0.02, 1e-12);
}

// A link has 30 N on a held copy; then the partner answers, and wants next to nothing. The force
// falls by 0.8 N a frame.
TEST(GentleLinks, FallingStiffnessObeysTheForceRateLimit) {
  LinkBench bench({*MakeLaw("p+d"), {.energy_gate = false}});
  bench.body.Join(kOther);
  for (int i = 0; i < 4000; ++i) bench.Frame(0, 4, 1e3);
  for (int i = 0; i < 200; ++i) bench.Frame(0.08, 4, 1e3);
  ASSERT_GT(0.08 * bench.stiffness(), 30);
  double last = 0.08 * bench.stiffness();
  double most = 0;
  for (int i = 0; i < 200; ++i) {
    bench.Frame(0.08, 4, 1);
    most = std::max(most, last - 0.08 * bench.stiffness());
    last = 0.08 * bench.stiffness();
  }
  EXPECT_NEAR(most, 0.8, 0.01);
  EXPECT_LT(last, 0.1);
}

}  // namespace
}  // namespace tandem
