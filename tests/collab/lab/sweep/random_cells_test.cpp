#include "collab/lab/sweep/random_cells.h"

#include <algorithm>
#include <array>
#include <set>

#include <gtest/gtest.h>

#include "collab/lab/case/case_file.h"
#include "collab/lab/sweep/random_verdict.h"

namespace tandem {
namespace {

LabCase CaseOf(std::uint64_t seed) {
  Result<LabCase> test = ParseCase(RandomCase(seed), "a drawn case");
  EXPECT_TRUE(test) << seed;
  return *std::move(test);
}

TEST(RandomCells, AreValidCasesWithinTheirRanges) {
  std::set<std::string> scenes;
  std::set<LabMotion> motions;
  std::set<std::size_t> users;
  double farthest = 0;
  double longest = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    const LabCase test = CaseOf(seed);
    scenes.insert(test.scene);
    motions.insert(test.motion);
    users.insert(test.users);
    EXPECT_GE(test.publish_hz, 10);
    EXPECT_LE(test.publish_hz, 1000);
    EXPECT_LE(test.delay_s, 1.2);
    longest = std::max(longest, test.delay_s);
    for (const LabHand& hand : test.hands) {
      EXPECT_GE(hand.impedance.mass, 0.1);
      EXPECT_LE(hand.impedance.mass, 5);
      EXPECT_GE(hand.impedance.damping, 0.3);
      EXPECT_LE(hand.impedance.damping, 20);
      EXPECT_LE(hand.impedance.stiffness, 3000);
      if (hand.grasp_B) farthest = std::max(farthest, hand.grasp_B->norm());
    }
  }
  EXPECT_EQ(scenes.size(), 5U);
  EXPECT_EQ(motions.size(), 7U);
  EXPECT_EQ(*users.begin(), 2U);
  EXPECT_EQ(*users.rbegin(), 8U);
  EXPECT_GT(farthest, 0.09);
  EXPECT_LE(farthest, 0.1 + 1e-4);
  EXPECT_GT(longest, 1.1);
}

TEST(RandomCells, BurstsLoseUpToHalfOfAllSamples) {
  double most = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const LabCase test = CaseOf(seed);
    LinkConditions way = test.network.there;
    if (way.burst_enter == 0) continue;
    way.loss = 0;
    LinkConditioner conditioner(way, seed);
    constexpr int kSamples = 40'000;
    int lost = 0;
    std::array<std::int64_t, 2> due{};
    for (std::int64_t i = 0; i < kSamples; ++i)
      lost += conditioner.Due(i * 1'000'000, due) == 0 ? 1 : 0;
    most = std::max(most, static_cast<double>(lost) / kSamples);
  }
  EXPECT_GT(most, 0.4);
  EXPECT_LT(most, 0.55);
}

TEST(RandomCells, DependOnlyOnTheirSeed) {
  const std::vector<SweepCell> cells = RandomCells(40, 3);
  ASSERT_EQ(cells.size(), 3U);
  EXPECT_EQ(cells[2].case_json, RandomCase(42));
  EXPECT_EQ(cells[2].number, 2U);
  EXPECT_NE(cells[1].case_json, cells[2].case_json);
  EXPECT_NE(cells[1].key, cells[2].key);
}

CellOutcome Outcome(Verdict verdict, double energy_J, double tail_m_s) {
  CellOutcome outcome;
  outcome.result.verdict = verdict;
  outcome.result.metrics.generated_J = energy_J;
  outcome.result.metrics.tail_rms = tail_m_s;
  outcome.predicted = Prediction{10, 100};
  return outcome;
}

TEST(RandomJudge, CountsUnstableActiveAndMovingCells) {
  const std::vector<SweepCell> cells = RandomCells(7, 4);
  RandomJudge judge(7);
  judge.See(cells[3], Outcome(Verdict::kStable, 0, 6e-4));
  judge.See(cells[0], Outcome(Verdict::kStable, 0.9e-3, 4e-4));
  judge.See(cells[2], Outcome(Verdict::kUnstable, 2e-3, 1e-3));
  judge.See(cells[1], Outcome(Verdict::kUndecided, 0, 0));
  const RandomSummary summary = judge.Finish();
  EXPECT_EQ(summary.cells, 4U);
  EXPECT_EQ(summary.failing, 3U);
  EXPECT_EQ(summary.not_stable, 2U);
  EXPECT_EQ(summary.predicted_stable, 4U);
  EXPECT_EQ(summary.predicted_stable_measured_unstable, 1U);
  EXPECT_DOUBLE_EQ(summary.max_energy_mJ, 2);
  EXPECT_DOUBLE_EQ(summary.max_tail_rms_mm_s, 1);
  ASSERT_EQ(summary.worst.size(), 3U);
  EXPECT_EQ(summary.worst[0].seed, 9U);
  EXPECT_EQ(summary.worst[0].reasons.size(), 3U);
}

TEST(RandomJudge, NonFiniteResultFails) {
  const std::vector<SweepCell> cells = RandomCells(1, 1);
  RandomJudge judge(1);
  judge.See(cells[0], Outcome(Verdict::kStable, std::nan(""), std::nan("")));
  EXPECT_EQ(judge.Finish().failing, 1U);
}

}  // namespace
}  // namespace tandem
