#include "collab/lab/run/case_run.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stability/free_box.h"

namespace tandem {
namespace {

using testing::FreeBox;
using testing::HandOfBox;
using testing::LossyNetwork;

struct Cell {
  const char* hand;
  double delay_s;
  std::size_t users = 2;
  bool lossy = false;
  LabMotion motion = LabMotion::kKick;
};

/// The test's own measure of a run, frame by frame and without any bins: every sample is kept.
struct OwnMeasure {
  void See(std::span<const UserFrame> users) {
    double square = 0;
    double apart = 0;
    for (const UserFrame& user : users) {
      square += SquaredSpeed(user.state.V_WB);
      work -= 1e-3 * user.ground_damping * SquaredSpeed(user.state.V_WB);
      for (std::size_t link = 0; link < user.link_count; ++link) {
        const Wrench& F = user.links_B_W[link];
        work += 1e-3 * (F.f.dot(user.state.V_WB.v) + F.tau.dot(user.state.V_WB.w));
      }
      for (const UserFrame& other : users) {
        apart = std::max(apart, (user.state.X_WB.p - other.state.X_WB.p).norm());
      }
    }
    squares.push_back(square);
    aparts.push_back(apart);
    generated = std::max(generated, work);
    stiffnesses.push_back(users[0].links[0].stiffness);
    loop_age_s = users[0].links[0].loop_age_s;
  }
  static double SquaredSpeed(const Twist& V) {
    const Inertia& body = FreeBox().inertia();
    return V.v.squaredNorm() + V.w.dot(body.I_B * V.w) / body.mass;
  }
  static double Mean(const std::vector<double>& values, std::size_t last) {
    return std::accumulate(values.end() - static_cast<std::ptrdiff_t>(last), values.end(), 0.0) /
           static_cast<double>(last);
  }

  std::vector<double> squares;      // m^2/s^2, summed over the users
  std::vector<double> aparts;       // m
  std::vector<double> stiffnesses;  // N/m, of a link
  double work = 0;                  // J
  double generated = 0;
  double loop_age_s = 0;
};

// Another measure of the same runs, kept apart: the test's own.
TEST(RunCase, MetricsMatchTheFrames) {
  for (const Cell& cell :
       {Cell{"off", 0.1}, Cell{"heavy", 0.3}, Cell{"relaxed", 0.02}, Cell{"off", 0.1, 2, true},
        Cell{"off", 0.1, 3}, Cell{"relaxed", 0.1, 2, false, LabMotion::kMove}}) {
    SCOPED_TRACE(std::string(cell.hand) + " at " + std::to_string(cell.delay_s) + " s");
    LabCase test;
    test.users = cell.users;
    test.hands = {HandOfBox(cell.hand)};
    test.motion = cell.motion;
    test.law.gate = false;
    test.delay_s = cell.delay_s;
    if (cell.lossy) {
      test.network = LossyNetwork();
      test.publish_hz = 100;
    }
    OwnMeasure own;
    const CaseResult run = RunCase(test, FreeBox(), [&](double, std::span<const UserFrame> users) {
      own.See(users);
    });
    ASSERT_FALSE(run.fault) << run.fault->what;
    const Metrics& metrics = run.metrics;
    ASSERT_EQ(own.aparts.size(), 12000U);
    EXPECT_NEAR(metrics.peak_apart, *std::ranges::max_element(own.aparts), 1e-9);
    EXPECT_GT(metrics.peak_apart, 1e-3);
    EXPECT_NEAR(metrics.last_apart, OwnMeasure::Mean(own.aparts, 1000), 1e-9);
    const double stiffness = OwnMeasure::Mean(own.stiffnesses, 1000);
    EXPECT_NEAR(metrics.stiffness, stiffness, 0.01 * stiffness);
    EXPECT_NEAR(metrics.loop_age_s, own.loop_age_s, cell.lossy ? 0.05 : 0.003);
    EXPECT_NEAR(metrics.generated_J, own.generated, 1e-6);
    EXPECT_NEAR(metrics.tail_rms, std::sqrt(OwnMeasure::Mean(own.squares, 1200)), 1e-6);
    EXPECT_EQ(metrics.clip_share, 0.0);
    EXPECT_EQ(metrics.frames, 12000);
    EXPECT_EQ(run.verdict, Verdict::kStable);
  }
}

// The hand of a file goes 40 mm along y, with a grasp of its own. The other follows.
TEST(RunCase, HandFromAFileFollowsItsScript) {
  LabCase test;
  HandScript script;
  script.X_BD.p = Vec3(0, 0, 0.05);
  script.waypoints = {{0, Vec3::Zero(), Quat::Identity()}, {2, Vec3(0, 0.04, 0), Quat::Identity()}};
  test.hands = {{"left", script.impedance, script}, HandOfBox("relaxed")};
  Vec3 first = Vec3::Zero();
  Vec3 other = Vec3::Zero();
  double turned = 0;
  const CaseResult run = RunCase(test, FreeBox(), [&](double, std::span<const UserFrame> users) {
    first = users[0].state.X_WB.p;
    other = users[1].state.X_WB.p;
    turned = std::max(turned, users[0].state.V_WB.w.norm());
  });
  ASSERT_FALSE(run.fault) << run.fault->what;
  EXPECT_EQ(run.verdict, Verdict::kStable);
  EXPECT_NEAR((first - Vec3(0, 0.04, 0)).norm(), 0, 1e-3);
  EXPECT_NEAR((other - first).norm(), 0, 1e-3);
  EXPECT_GT(turned, 0.01);
}

// The case has 200 N/m without drag at 100 ms, hands off: 10 times k_crit.
TEST(RunCase, DetectsInstability) {
  LabCase test;
  test.hands = {HandOfBox("off")};
  test.law.name = "constant";
  test.law.gate = false;
  const CaseResult run = RunCase(test, FreeBox());
  EXPECT_EQ(run.verdict, Verdict::kUnstable);
  EXPECT_TRUE(run.metrics.diverged);
  EXPECT_GT(run.metrics.generated_J, 0.01);
}

TEST(RunCase, IsDeterministicPerSeed) {
  LabCase test;
  test.hands = {HandOfBox("relaxed")};
  test.network = LossyNetwork();
  test.publish_hz = 100;
  const CaseResult run = RunCase(test, FreeBox());
  EXPECT_EQ(RunCase(test, FreeBox()).digest, run.digest);
  test.seed = 2;
  EXPECT_NE(RunCase(test, FreeBox()).digest, run.digest);
}

// where the ways differ, one link pulls 1.6 s before the other; a body that one link alone pulls
// gets energy of a knock: 33 mJ
TEST(RunCase, KnockWaitsForAllLinks) {
  LabCase test;
  test.hands = {HandOfBox("off")};
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
TEST(RunCase, SendersHaveIndependentPhases) {
  LabCase test;
  test.hands = {HandOfBox("relaxed")};
  test.publish_hz = 100;
  std::set<std::uint64_t> digests;
  for (test.seed = 1; test.seed <= 8; ++test.seed) {
    digests.insert(RunCase(test, FreeBox()).digest);
  }
  EXPECT_GE(digests.size(), 3U);
}

TEST(RunCase, ReportsLoopsThatStayOpen) {
  LabCase test;
  test.hands = {HandOfBox("off")};
  test.network.there.loss = 1;
  const CaseResult run = RunCase(test, FreeBox());
  ASSERT_TRUE(run.fault);
  EXPECT_EQ(run.fault->what, "the loops between the users do not close within 8 s");
}

}  // namespace
}  // namespace tandem
