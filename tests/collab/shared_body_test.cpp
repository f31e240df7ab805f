#include "collab/shared_body.h"

#include <gtest/gtest.h>

#include "engine/world/world.h"

namespace tandem {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr PeerId kMe = 1;
constexpr PeerId kOther = 2;
constexpr ObjectId kObject = 3;

/// Our end of a link, and a partner of which each test says what it sends.
struct Bench {
  explicit Bench(const SharedBody::Options& options = {*MakeLaw("p+d")})
      : body(kMe, kObject, {0.3, 1e-4 * Mat3::Identity()}, options) {
    inputs.bodies.resize(1);
    for (int i = 0; i < 3000; ++i) Alone();  // what was sent may be echoed
  }

  /// A frame in which nothing comes.
  void Alone() {
    now += kMs;
    body.Prepare(now, own, inputs);
    body.Describe(now, ++frame, report, out);
  }

  /// A frame: the partner's state, held still at `place`, which echoes our stamp of `loop_ms` ago.
  void Frame(double place_m, std::int64_t loop_ms, double its_stiffness, bool heard = true) {
    if (!heard) return Alone();
    Hear(kOther, place_m, loop_ms, its_stiffness);
    Alone();
  }

  void Hear(PeerId peer, double place_m, std::int64_t loop_ms, double its_stiffness) {
    ++seq;
    const std::int64_t then = now + kMs;
    ObjectState state;
    state.peer = peer;
    state.object = kObject;
    state.epoch = 1;
    state.seq = seq;
    state.sample_ns = 7'000'000'000 + then;  // another clock
    state.X_WB.p.x() = place_m;
    state.V_WB.v.x() = its_speed;
    state.V_WB.w.x() = its_turning;
    body.OnState(state);
    CouplingLinks links;
    links.from = peer;
    links.object = kObject;
    links.seq = seq;
    links.count = 1;
    links.entries[0] = {
        .to = kMe, .echo_ns = then - loop_ms * kMs, .stiffness = its_stiffness, .applied_B_W = {}};
    links.entries[0].applied_B_W.f.x() = its_force;
    body.OnLinks(links);
  }
  /// Of the one link's energy gate, J.
  double tank() const {
    std::array<LinkView, kMaxLinks> views;
    EXPECT_EQ(body.Links(now, views), 1U);
    return views[0].tank;
  }
  double stiffness() const {
    return inputs.link_count == 0 ? 0.0 : inputs.links[0].gains.stiffness;
  }

  double its_force = 0;    // N, that the partner says is on its instance
  double its_speed = 0;    // m/s, of its instance
  double its_turning = 0;  // rad/s
  SharedBody body;
  RigidState own;
  StepInputs inputs;
  StepReport report;
  CouplingLinks out;
  std::uint32_t frame = 0;
  std::int64_t now = 1000 * kMs;
  std::uint32_t seq = 0;
};

TEST(SharedBody, IsAloneUntilTheLoopIsClosed) {
  Bench bench;
  bench.body.Join(kOther);
  bench.Frame(0, 200, 100, false);
  EXPECT_EQ(bench.inputs.link_count, 0U);
  EXPECT_EQ(bench.body.coupled(), 0U);
  bench.Frame(0, 200, 100);
  EXPECT_EQ(bench.body.coupled(), 1U);
}

TEST(SharedBody, IgnoresThoseWhoDoNotHoldTheBody) {
  Bench bench;
  bench.Frame(0.01, 200, 100);
  EXPECT_EQ(bench.inputs.link_count, 0U);
}

TEST(SharedBody, UsesTheSmallerStiffnessOfBothEnds) {
  Bench bench;
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
  Bench bench;
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

TEST(SharedBody, OldSamplesChangeNothing) {
  Bench bench;
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

TEST(SharedBody, ALostPartnersPullFadesOverTwoHundredMilliseconds) {
  Bench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 2000; ++i) bench.Frame(0.01, 200, 60);
  const double before = bench.stiffness();
  bench.body.Part(kOther);
  for (int i = 1; i <= 100; ++i) bench.Frame(0.01, 200, 60, false);
  EXPECT_NEAR(bench.stiffness(), 0.5 * before, 0.02 * before);
  for (int i = 0; i < 101; ++i) bench.Frame(0.01, 200, 60, false);
  EXPECT_EQ(bench.inputs.link_count, 0U);
  EXPECT_EQ(bench.inputs.ground_damping, 0.0);
  EXPECT_NEAR(bench.body.mean_delay_s(), 0.1, 1e-9);  // what was measured stays so
  // back again: from nothing, without a kick
  bench.body.Join(kOther);
  bench.Frame(0.05, 200, 60);
  bench.Frame(0.05, 200, 60);
  EXPECT_LT(bench.stiffness(), 1.0);
}

TEST(SharedBody, ASilentPartnerIsLetGoWhenTheLoopIsTooOld) {
  Bench bench;
  bench.body.Join(kOther);
  for (int i = 0; i < 1000; ++i) bench.Frame(0.01, 100, 100);
  EXPECT_GT(bench.stiffness(), 50);
  for (int i = 0; i < 2600; ++i) bench.Frame(0.01, 100, 100, false);
  EXPECT_LT(bench.stiffness(), 0.1);
}

// One whose loop is older than 2.4 s is out of use by itself: the other link neither ends nor is
// made for that delay, nor shared with it.
TEST(SharedBody, ALoopThatIsTooOldEndsNoOtherLink) {
  Bench bench;
  bench.body.Join(kOther);
  bench.body.Join(3);
  for (int i = 0; i < 3000; ++i) {
    bench.Hear(3, 0, 2600, 500);
    bench.Frame(0, 20, 500);
  }
  ASSERT_EQ(bench.inputs.link_count, 2U);
  EXPECT_NEAR(bench.inputs.links[0].gains.stiffness,
              (*MakeLaw("p+d"))->Link(LawInputsAt(0.02, 2, 1.5)).stiffness, 1e-6);
  EXPECT_EQ(bench.inputs.links[1].gains.stiffness, 0.0);
  EXPECT_LT(bench.inputs.ground_damping, 10.0);
}

// An echo of the future, or of a time at which nothing was sent, would feign a short loop.
TEST(SharedBody, EchoesOfStampsNeverSentAreRefused) {
  Bench bench;
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

// 400 N/m stretched by 7.5 mm, 3 N: of a partner that falls silent, then is told to be lost, and
// the other way when a third one comes; at most 1 N within 100 ms each.
TEST(SharedBody, APullOfThreeNewtonsGoesGently) {
  for (const bool third_comes : {false, true}) {
    SCOPED_TRACE(third_comes);
    Bench bench;
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
TEST(SharedBody, ACappedLinkFallsGentlyToWhatItMayPullWith) {
  Bench bench;
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

// Both wrenches of a link add up to nothing, or the larger share of them that does not.
TEST(SharedBody, ComparesTheTwoWrenchesOfALink) {
  Bench bench;
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

// Whatever a partner says that its end felt: what we feel is from its poses alone.
TEST(SharedBody, WhatAPartnerSaysOfItsForceIsNeverApplied) {
  std::array<StepInputs, 2> inputs;
  for (const std::size_t lies : {0U, 1U}) {
    Bench bench;
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
TEST(SharedBody, DampingBetweenInstancesIsNeverAboveTheLaws) {
  Bench bench({*MakeLaw("p+dd"), false});
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
  EXPECT_LE(most, 10.0);  // B
}

// Of a damper that moves along nothing is drawn; of one that pulls us on, what it gives less what
// it takes.
TEST(SharedBody, AGatePaysForWhatADamperGivesOnBalance) {
  Bench bench({*MakeLaw("p+dd")});
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

// The same of a damper that turns us.
TEST(SharedBody, AGatePaysForWhatADamperOfTurningGives) {
  Bench bench({*MakeLaw("p+dd")});
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

// The peak of a loop of 600 ms is forgotten after two seconds of 40 ms: what drags there are fall
// by 10 N s/m in a tenth of a second, not in a frame.
TEST(SharedBody, DragsFallGentlyWhenALoopGrowsShorter) {
  Bench bench({*MakeLaw("p+dd"), false});
  bench.body.Join(kOther);
  for (int i = 0; i < 4000; ++i) bench.Frame(0, 600, 1e3);
  double link = bench.inputs.links[0].gains.damping;
  double ground = bench.inputs.ground_damping;
  EXPECT_NEAR(link, 10, 1e-9);
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

// A sample that comes late shows another place and another speed: 0.8 N a frame by both together,
// and in the end all of it.
TEST(SharedBody, NoSampleChangesALinksForceByMoreThanSoMuchAFrame) {
  Bench bench({*MakeLaw("p+dd"), false});
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

// 30 N on a held copy; then the partner answers, and wants next to nothing: 0.8 N a frame.
TEST(SharedBody, NoFallOfStiffnessTakesMoreThanSoMuchForceAFrame) {
  Bench bench({*MakeLaw("p+d"), false});
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

// For the lab: the spring's force goes to the partner, and what it says is applied.
TEST(SharedBody, ExchangesForcesWhereItIsToldTo) {
  Bench bench({*MakeLaw("p+d"), true, true});
  bench.body.Join(kOther);
  bench.its_force = 3;
  for (int i = 0; i < 3000; ++i) bench.Frame(0.01, 20, 100);
  EXPECT_EQ(bench.inputs.links[0].gains.stiffness, 0.0);
  EXPECT_NEAR(bench.inputs.links[0].push_B_W.f.x(), -3.0, 1e-12);
  EXPECT_NEAR(bench.out.entries[0].applied_B_W.f.x(), 0.01 * 100, 1e-6);
}

TEST(SharedBody, BeyondFiveTwelfthsOfATurnTheMomentKeepsItsSizeAndItsWay) {
  Bench bench;
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

TEST(SharedBody, TellsEachPartnerTheNewestStampItHolds) {
  Bench bench;
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
