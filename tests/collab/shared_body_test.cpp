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
  Bench() : body(kMe, kObject, {0.3, 1e-4 * Mat3::Identity()}, {}) { inputs.bodies.resize(1); }

  /// A frame: the partner's state, held still at `place`, which echoes our stamp of `loop_ms` ago.
  void Frame(double place_m, std::int64_t loop_ms, double its_stiffness, bool heard = true) {
    now += kMs;
    ++seq;
    if (heard) {
      ObjectState state;
      state.peer = kOther;
      state.object = kObject;
      state.epoch = 1;
      state.seq = seq;
      state.sample_ns = 7'000'000'000 + now;  // another clock
      state.X_WB.p.x() = place_m;
      body.OnState(state);
      CouplingLinks links;
      links.from = kOther;
      links.object = kObject;
      links.seq = seq;
      links.count = 1;
      links.entries[0] = {
          .to = kMe, .echo_ns = now - loop_ms * kMs, .stiffness = its_stiffness, .applied_B_W = {}};
      body.OnLinks(links);
    }
    body.Prepare(now, own, inputs);
  }
  double stiffness() const {
    return inputs.link_count == 0 ? 0.0 : inputs.links[0].gains.stiffness;
  }

  SharedBody body;
  RigidState own;
  StepInputs inputs;
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
  const double own = LinkStiffness(CouplingLaw::kPlusDamping, {}, 0.2, 2, 0.3 + 1.2);
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
  old.X_WB.p.x() = 9.0;
  bench.body.OnState(old);
  bench.body.Prepare(bench.now, bench.own, bench.inputs);
  EXPECT_EQ(bench.inputs.links[0].copy.X_WA.p.x(), 0.01);
  old.epoch = 2;  // a new grab counts anew
  bench.body.OnState(old);
  bench.body.Prepare(bench.now, bench.own, bench.inputs);
  EXPECT_EQ(bench.inputs.links[0].copy.X_WA.p.x(), 9.0);
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
