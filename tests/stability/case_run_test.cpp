#include "collab/lab/case_run.h"

#include <set>

#include <gtest/gtest.h>

#include "tests/stability/type2_run.h"

namespace tandem {
namespace {

using testing::RunType2;
using testing::SharedBoxInSpace;
using testing::Type2Case;
using testing::Type2Run;

LabScene FreeBox() {
  return {.model = SharedBoxInSpace(), .object = 0, .X_BD = {}};
}

LabHand Hand(const std::string& name) {
  return *HandNamed(name, SharedBoxInSpace()->bodies[0].inertia);
}

struct Cell {
  const char* hand;
  double delay_s;
  std::size_t users = 2;
  bool lossy = false;
  LabMotion motion = LabMotion::kKick;
};

// Another measure of the same runs, kept apart: the test's own.
TEST(RunCase, MeasuresWhatTheTestsOwnRunsMeasure) {
  for (const Cell& cell :
       {Cell{"off", 0.1}, Cell{"heavy", 0.3}, Cell{"relaxed", 0.02}, Cell{"off", 0.1, 2, true},
        Cell{"off", 0.1, 3}, Cell{"relaxed", 0.1, 2, false, LabMotion::kMove}}) {
    SCOPED_TRACE(std::string(cell.hand) + " at " + std::to_string(cell.delay_s) + " s");
    const bool moves = cell.motion == LabMotion::kMove;
    LabCase test;
    test.users = cell.users;
    test.hands = {Hand(cell.hand)};
    test.motion = cell.motion;
    test.law.gate = false;
    test.delay_s = cell.delay_s;
    Type2Case other;
    other.users = cell.users;
    other.hand = test.hands[0].impedance;
    other.coupling.gate = false;
    other.conditions.delay_ms = 1e3 * cell.delay_s;
    other.kick = moves ? 0 : 5;
    if (cell.lossy) {
      test.network.there = test.network.back = {.jitter_ms = 30, .loss = 0.05};
      test.publish_hz = other.publish_hz = 100;
      other.conditions.jitter_ms = 30;
      other.conditions.loss = 0.05;
    }
    if (moves) {
      HandImpedance moving = other.hand;
      moving.stiffness = 300;
      other.hands = {moving};
      other.ways = {{{0, Vec3::Zero(), Quat::Identity()},
                     {2, Vec3::Zero(), Quat::Identity()},
                     {3, Vec3(0.2, 0, 0), Quat::Identity()}}};
    }
    const CaseResult run = RunCase(test, FreeBox());
    ASSERT_FALSE(run.fault) << run.fault->what;
    const Type2Run expected = RunType2(other);
    const Metrics& metrics = run.metrics;
    const double tolerance = cell.lossy ? 0.1 : 0.01;  // other phases and other losses
    EXPECT_NEAR(metrics.peak_apart, expected.peak_apart, tolerance * expected.peak_apart);
    EXPECT_NEAR(metrics.last_apart, expected.last_apart, 1e-4);
    EXPECT_NEAR(metrics.stiffness, expected.last_stiffness, tolerance * expected.last_stiffness);
    EXPECT_NEAR(metrics.loop_age_s, expected.longest_loop, cell.lossy ? 0.05 : 0.003);
    EXPECT_NEAR(metrics.generated_J, expected.generated, 1e-6);
    EXPECT_NEAR(metrics.tail_rms, expected.tail_rms, 1e-6);
    EXPECT_EQ(metrics.clip_share, 0.0);
    EXPECT_EQ(metrics.frames, 12000);
    EXPECT_EQ(run.verdict, Verdict::kStable);
  }
}

// 200 N/m without drag at 100 ms, hands off: 10 times k_crit.
TEST(RunCase, CatchesWhatIsUnstable) {
  LabCase test;
  test.hands = {Hand("off")};
  test.law.name = "constant";
  test.law.gate = false;
  const CaseResult run = RunCase(test, FreeBox());
  EXPECT_EQ(run.verdict, Verdict::kUnstable);
  EXPECT_TRUE(run.metrics.blew_up);
  EXPECT_GT(run.metrics.generated_J, 0.01);
}

TEST(RunCase, GivesTheSameBitsAgainAndOthersForAnotherSeed) {
  LabCase test;
  test.hands = {Hand("relaxed")};
  test.network.there = test.network.back = {.jitter_ms = 30, .loss = 0.05};
  test.publish_hz = 100;
  const CaseResult run = RunCase(test, FreeBox());
  EXPECT_EQ(RunCase(test, FreeBox()).digest, run.digest);
  test.seed = 2;
  EXPECT_NE(RunCase(test, FreeBox()).digest, run.digest);
}

// where the ways differ, one link pulls 1.6 s before the other; pulled by one alone, a knock gives
// energy: 33 mJ
TEST(RunCase, KnocksOnceEveryLinkPulls) {
  LabCase test;
  test.hands = {Hand("off")};
  test.law.gate = false;
  test.delay_s = 1;
  test.network.skew = 0.8;
  test.seconds = 10;
  bool moved = false;
  const CaseResult run = RunCase(test, FreeBox(), [&](double, std::span<const UserFrame> users) {
    moved = moved || users[0].state.V_WB.v.norm() > 1e-3;
    if (!moved) return;
    for (const UserFrame& user : users) {
      ASSERT_EQ(user.link_count, 1U);
      EXPECT_GT(user.links[0].stiffness, 0.0);
    }
  });
  EXPECT_TRUE(moved);
  EXPECT_LT(run.metrics.generated_J, 1e-6);
}

// Nothing else of a clean line depends on the seed.
TEST(RunCase, SendersThatSendNowAndThenDoSoAtTimesOfTheirOwn) {
  LabCase test;
  test.hands = {Hand("relaxed")};
  test.publish_hz = 100;
  std::set<std::uint64_t> digests;
  for (test.seed = 1; test.seed <= 8; ++test.seed) {
    digests.insert(RunCase(test, FreeBox()).digest);
  }
  EXPECT_GE(digests.size(), 3U);
}

TEST(RunCase, TellsThatLoopsDoNotClose) {
  LabCase test;
  test.hands = {Hand("off")};
  test.network.there.loss = 1;
  const CaseResult run = RunCase(test, FreeBox());
  ASSERT_TRUE(run.fault);
  EXPECT_EQ(run.fault->what, "the loops between the users do not close within 8 s");
}

}  // namespace
}  // namespace tandem
