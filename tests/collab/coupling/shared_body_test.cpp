#include "collab/coupling/shared_body.h"

#include <gtest/gtest.h>

#include "tests/collab/coupling/link_bench.h"

namespace tandem {
namespace {

using testing::kMe;
using testing::kObject;
using testing::kOther;
using testing::LinkBench;

TEST(SharedBody, IsUncoupledUntilTheLoopIsClosed) {
  LinkBench bench;
  bench.body.Join(kOther);
  bench.Frame(0, 200, 100, false);
  EXPECT_EQ(bench.inputs.link_count, 0U);
  EXPECT_EQ(bench.body.coupled(), 0U);
  bench.Frame(0, 200, 100);
  EXPECT_EQ(bench.body.coupled(), 1U);
}

TEST(SharedBody, IgnoresPeersThatDoNotHoldTheBody) {
  LinkBench bench;
  bench.Frame(0.01, 200, 100);
  EXPECT_EQ(bench.inputs.link_count, 0U);
}

TEST(SharedBody, UsesTheSmallerStiffnessOfBothEnds) {
  LinkBench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 3000; ++i) bench.Frame(0, 200, 30);
  EXPECT_NEAR(bench.stiffness(), 30, 1e-6);
  for (int i = 0; i < 3000; ++i) bench.Frame(0, 200, 400);
  const double own = (*MakeLaw("p+d"))->Link(LawInputsAt(0.2, 2, 0.3 + 1.2)).stiffness;
  EXPECT_NEAR(bench.stiffness(), own, 0.01);
  EXPECT_NEAR(bench.body.mean_delay_s(), 0.1, 1e-9);
  EXPECT_NEAR(bench.body.delay_s(bench.now), 0.1, 1e-9);
}

TEST(SharedBody, RaisesStiffnessSlowlyAndLowersItAtOnce) {
  LinkBench bench;
  bench.body.Join(kOther);
  double last = 0;
  double energy = 0;
  const double stretch = 0.02;
  for (int i = 0; i < 2000; ++i) {
    bench.Frame(stretch, 4, 500);
    EXPECT_LE(bench.stiffness() - last, 400e-3 + 1e-9);
    energy += 0.5 * std::max(0.0, bench.stiffness() - last) * stretch * stretch;
    last = bench.stiffness();
  }
  EXPECT_GT(last, 50);
  EXPECT_LE(energy, 0.02 * 2.0 * 1.001);  // 20 mW over two seconds
  for (int i = 0; i < 100; ++i) bench.Frame(stretch, 4, 10);
  EXPECT_NEAR(bench.stiffness(), 10, std::exp(-5.0) * (last - 10) + 0.1);  // five times 20 ms
}

TEST(SharedBody, OutdatedSamplesChangeNothing) {
  LinkBench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 10; ++i) bench.Frame(0.01, 200, 100);
  ObjectState old;
  old.peer = kOther;
  old.object = kObject;
  old.epoch = 1;
  old.seq = 5;
  old.X_WB.p.x() = 0.02;
  bench.body.OnState(old);
  bench.body.Prepare(bench.now, bench.own, bench.inputs);
  EXPECT_EQ(bench.inputs.links[0].copy.X_WA.p.x(), 0.01);
  old.epoch = 2;  // a new grab counts anew
  bench.body.OnState(old);
  bench.body.Prepare(bench.now, bench.own, bench.inputs);
  EXPECT_EQ(bench.inputs.links[0].copy.X_WA.p.x(), 0.02);
}

TEST(SharedBody, LostCoupledPeersForceFadesOver200Milliseconds) {
  LinkBench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 2000; ++i) bench.Frame(0.01, 200, 60);
  const double before = bench.stiffness();
  bench.body.Part(kOther);
  for (int i = 1; i <= 100; ++i) bench.Frame(0.01, 200, 60, false);
  EXPECT_NEAR(bench.stiffness(), 0.5 * before, 0.02 * before);
  for (int i = 0; i < 101; ++i) bench.Frame(0.01, 200, 60, false);
  EXPECT_EQ(bench.inputs.link_count, 0U);
  EXPECT_EQ(bench.inputs.ground_damping, 0.0);
  EXPECT_NEAR(bench.body.mean_delay_s(), 0.1, 1e-9);  // the measured delay stays
  // back again: from nothing, without a kick
  bench.body.Join(kOther);
  bench.Frame(0.05, 200, 60);
  bench.Frame(0.05, 200, 60);
  EXPECT_LT(bench.stiffness(), 1.0);
}

// Only the session says who is lost: a link over which nothing comes is made for its age.
TEST(SharedBody, SilentCoupledPeersLinkSoftensWithoutEnding) {
  LinkBench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 1000; ++i) bench.Frame(0.01, 100, 500);
  double last = bench.stiffness();
  EXPECT_GT(last, 50);
  bench.own.V_WB.v.x() = 0.02;  // at rest it would follow slowly
  for (const int age_ms : {600, 1100, 2600, 5100}) {
    while (bench.now - bench.received_ns < age_ms * kMs) bench.Alone();
    const double allowed =
        (*MakeLaw("p+d"))->Link(LawInputsAt(1e-3 * (100 + age_ms), 2, 1.5)).stiffness;
    EXPECT_NEAR(bench.stiffness(), allowed, 0.01 * allowed) << age_ms;
    EXPECT_LT(bench.stiffness(), last);
    last = bench.stiffness();
  }
  EXPECT_GT(last, 15);
}

// After a first silence of two seconds, one of nearly three does not soften the link of a part at
// rest. One of more than five seconds does.
TEST(SharedBody, OnlyUnusualSilenceSoftensTheLinkOfARestingPart) {
  LinkBench bench;
  bench.body.Join(kOther);
  const auto hear = [&bench](int frames) {
    for (int i = 0; i < frames; ++i) bench.Frame(0.05, 100, 500);
  };
  const auto after_silence = [&bench](int frames) {
    for (int i = 0; i < frames; ++i) bench.Alone();
    return bench.stiffness();
  };
  hear(6000);
  const double before = bench.stiffness();
  EXPECT_LT(after_silence(2000), 0.7 * before);
  hear(5000);
  const double later = bench.stiffness();
  EXPECT_GT(after_silence(2900), 0.99 * later);
  hear(5000);
  EXPECT_LT(after_silence(5500), 0.9 * later);
}

// A link whose loop is older than 2.4 s is made for that age by itself: the other is made for 2.4 s
// at the most, and what drag the older one needs is there.
TEST(SharedBody, OldLoopSoftensMainlyItsOwnLink) {
  LinkBench bench;
  bench.body.Join(kOther);
  bench.body.Join(3);
  for (int i = 0; i < 3000; ++i) {
    bench.Hear(3, 0, 2900, 500);
    bench.Frame(0, 20, 500);
  }
  const auto law = *MakeLaw("p+d");
  ASSERT_EQ(bench.inputs.link_count, 2U);
  EXPECT_NEAR(bench.inputs.links[0].gains.stiffness, law->Link(LawInputsAt(2.4, 3, 1.5)).stiffness,
              1e-6);
  EXPECT_NEAR(bench.inputs.links[1].gains.stiffness, law->Link(LawInputsAt(2.9, 3, 1.5)).stiffness,
              1e-6);
  const double sum = bench.inputs.links[0].gains.stiffness + bench.inputs.links[1].gains.stiffness;
  EXPECT_NEAR(bench.inputs.ground_damping, law->GroundDamping(LawInputsAt(2.9, 3, 1.5), sum), 1e-6);
}

// An echo of the future, or of a time at which nothing was sent, would feign a short loop.
TEST(SharedBody, EchoesOfUnsentTimestampsAreRefused) {
  LinkBench bench;
  bench.body.Join(kOther);
  bench.Frame(0, 200, 500);
  EXPECT_EQ(bench.body.bad_echoes(), 0U);
  for (int i = 0; i < 3000; ++i) {
    bench.Hear(kOther, 0, 200, 500);
    CouplingLinks links;
    links.from = kOther;
    links.object = kObject;
    links.count = 1;
    for (const std::int64_t echo :
         {bench.now + 5 * kMs, bench.now - kMs / 2, std::int64_t{-7}, INT64_MAX}) {
      links.seq = ++bench.seq;
      links.entries[0] = {.to = kMe, .echo_ns = echo, .stiffness = 500, .applied_B_W = {}};
      bench.body.OnLinks(links);
    }
    bench.Alone();
  }
  EXPECT_EQ(bench.body.bad_echoes(), 12000U);
  EXPECT_NEAR(bench.stiffness(), (*MakeLaw("p+d"))->Link(LawInputsAt(0.2, 2, 1.5)).stiffness, 0.01);
}

// Both wrenches of a link add up to nothing. The figure is the larger share of them that does not.
TEST(SharedBody, ReportsTheDifferenceOfALinksWrenches) {
  LinkBench bench;
  bench.body.Join(kOther);
  bench.Frame(0.01, 20, 100);
  bench.report.links_B_W[0].f = Vec3(2, 0, 0);
  const auto disagreement = [&](double its_force) {
    CouplingLinks links;
    links.from = kOther;
    links.object = kObject;
    links.seq = ++bench.seq;
    links.count = 1;
    links.entries[0] = {.to = kMe, .echo_ns = bench.now, .stiffness = 100, .applied_B_W = {}};
    links.entries[0].applied_B_W.f.x() = its_force;
    bench.body.OnLinks(links);
    bench.Alone();
    std::array<LinkView, kMaxLinks> views;
    EXPECT_EQ(bench.body.Links(bench.now, views), 1U);
    EXPECT_EQ(views[0].peer, kOther);
    EXPECT_NEAR(views[0].force, 2.0, 1e-12);
    return views[0].disagreement;
  };
  EXPECT_NEAR(disagreement(-2.0), 0.0, 1e-12);
  EXPECT_NEAR(disagreement(-1.9), 0.05, 1e-12);
  EXPECT_NEAR(disagreement(2.5), 1.8, 1e-12);  // a wrong sign
}

// A partner may say anything of what its end felt. The force here comes from its poses alone.
TEST(SharedBody, ReportedCoupledPeerForceIsNeverApplied) {
  std::array<StepInputs, 2> inputs;
  for (const std::size_t lies : {0U, 1U}) {
    LinkBench bench;
    bench.body.Join(kOther);
    for (int i = 0; i < 3000; ++i) {
      bench.its_force = lies == 1 ? 1e4 : 0.0;
      bench.Frame(0.01, 20, 100);
    }
    inputs[lies] = bench.inputs;
  }
  ASSERT_EQ(inputs[1].link_count, 1U);
  ASSERT_GT(inputs[0].links[0].gains.stiffness, 50.0);
  EXPECT_EQ(inputs[1].links[0].gains.stiffness, inputs[0].links[0].gains.stiffness);
  EXPECT_EQ(inputs[1].links[0].copy.X_WA.p, inputs[0].links[0].copy.X_WA.p);
  EXPECT_EQ(inputs[1].ground_damping, inputs[0].ground_damping);
}

// A link that falls gently while its partner is silent has no more damping than the law gives.
TEST(SharedBody, LinkDampingNeverExceedsTheLaw) {
  LinkBench bench({*MakeLaw("p+dd"), {.energy_gate = false}});
  bench.body.Join(kOther);
  for (int i = 0; i < 4000; ++i) bench.Frame(0, 20, 1e3);
  for (int i = 0; i < 200; ++i) bench.Frame(0.05, 20, 1e3);
  ASSERT_GT(bench.stiffness(), 300);
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    bench.Alone();
    most = std::max(most, bench.inputs.links[0].gains.damping);
  }
  EXPECT_GT(bench.stiffness(), 100);
  EXPECT_GT(most, 5.0);
  EXPECT_LE(most, (*MakeLaw("p+dd"))->Link(LawInputsAt(2.03, 2, 1.5)).relative_damping);
}

// A gate draws nothing for a damper that moves along. For a damper that pulls us on it draws what
// the damper gives less what it takes.
TEST(SharedBody, GateCoversTheDampersNetEnergy) {
  LinkBench bench({*MakeLaw("p+dd")});
  bench.body.Join(kOther);
  for (int i = 0; i < 4000; ++i) bench.Frame(0, 200, 1e3);
  const double damping = bench.inputs.links[0].gains.damping;
  ASSERT_NEAR(damping, 8.0, 0.5);
  const double full = bench.tank();
  bench.its_speed = 0.3;
  bench.own.V_WB.v.x() = 0.3;
  for (int i = 0; i < 100; ++i) bench.Frame(0, 200, 1e3);
  EXPECT_GE(bench.tank(), full);  // ground damping only adds
  bench.own.V_WB.v.x() = 0;
  for (int i = 0; i < 100; ++i) bench.Frame(0, 200, 1e3);
  const double before = bench.tank();
  bench.own.V_WB.v.x() = 0.1;
  for (int i = 0; i < 100; ++i) bench.Frame(0, 200, 1e3);
  const double given = 0.1 * damping * (0.3 - 0.1) * 0.1;
  const double earned = 0.1 * 0.9 * bench.inputs.ground_damping * 0.1 * 0.1;
  EXPECT_NEAR(before - bench.tank(), given - earned, 0.02 * given);
}

// The same holds for a damper that turns us.
TEST(SharedBody, GateCoversTheRotationalDampersEnergy) {
  LinkBench bench({*MakeLaw("p+dd")});
  bench.body.Join(kOther);
  bench.its_turning = 30;
  for (int i = 0; i < 4000; ++i) bench.Frame(0, 200, 1e3);
  const double before = bench.tank();
  bench.own.V_WB.w.x() = 10;
  for (int i = 0; i < 100; ++i) bench.Frame(0, 200, 1e3);
  const double per_mass = 1e-4 / 0.3;  // m^2
  const double given = 0.1 * bench.inputs.links[0].gains.damping * per_mass * (30 - 10) * 10;
  const double earned = 0.1 * 0.9 * bench.inputs.ground_damping * per_mass * 10 * 10;
  EXPECT_GT(given - earned, 0.03);
  EXPECT_NEAR(before - bench.tank(), given - earned, 0.02 * given);
}

// For the lab, the spring's force goes to the partner, and the force that the partner says is
// applied.
TEST(SharedBody, ExchangesForcesWhenConfigured) {
  LinkBench bench({*MakeLaw("p+d"), {.exchange_forces = true}});
  bench.body.Join(kOther);
  bench.its_force = 3;
  for (int i = 0; i < 3000; ++i) bench.Frame(0.01, 20, 100);
  EXPECT_EQ(bench.inputs.links[0].gains.stiffness, 0.0);
  EXPECT_NEAR(bench.inputs.links[0].push_B_W.f.x(), -3.0, 1e-12);
  EXPECT_NEAR(bench.out.entries[0].applied_B_W.f.x(), 0.01 * 100, 1e-6);
}

TEST(SharedBody, MomentIsConstantBeyondFiveTwelfthsOfATurn) {
  LinkBench bench;
  bench.body.Join(kOther);
  ObjectState state;
  state.peer = kOther;
  state.object = kObject;
  for (int degrees = 0; degrees <= 200; degrees += 5) {
    state.seq = static_cast<std::uint32_t>(degrees + 1);
    state.X_WB.q = RotationBy(Vec3(0, 0, degrees * M_PI / 180));
    bench.body.OnState(state);
    bench.Alone();
    const Vec3 turn = RotationVector(bench.inputs.links[0].copy.X_WA.q);
    EXPECT_NEAR(turn.z(), std::min(degrees, 150) * M_PI / 180, 1e-9) << degrees;
  }
}

TEST(SharedBody, EchoesEachCoupledPeersNewestTimestamp) {
  LinkBench bench;
  bench.body.Join(kOther);
  bench.Frame(0, 200, 100);
  CouplingLinks out;
  StepReport report;
  report.links_B_W[0].f = Vec3(1, 2, 3);
  bench.body.Describe(bench.now, 77, report, out);
  ASSERT_EQ(out.count, 1U);
  EXPECT_EQ(out.from, kMe);
  EXPECT_EQ(out.object, kObject);
  EXPECT_EQ(out.seq, 77U);
  EXPECT_EQ(out.entries[0].to, kOther);
  EXPECT_EQ(out.entries[0].echo_ns, 7'000'000'000 + bench.now);
  EXPECT_EQ(out.entries[0].applied_B_W.f, Vec3(1, 2, 3));
}

}  // namespace
}  // namespace tandem
