#include "app/study/trial_order.h"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "tests/app/study/example_study.h"

namespace tandem {
namespace {

using testing::ExampleStudy;

/// Counts how often each treatment stands at each place, and directly after each other one.
struct Counts {
  std::map<std::pair<std::size_t, std::size_t>, int> places;
  std::map<std::pair<std::size_t, std::size_t>, int> follows;

  void Add(const std::vector<std::size_t>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      ++places[{i, row[i]}];
      if (i > 0) ++follows[{row[i - 1], row[i]}];
    }
  }
  /// Returns whether each of the n n places and of the n (n-1) pairs comes as often as any other.
  bool AreBalanced(std::size_t treatments) const {
    const auto even = [](const auto& counts, std::size_t size) {
      if (counts.size() != size) return false;
      const int first = counts.begin()->second;
      return std::ranges::all_of(counts, [first](const auto& one) {
        return one.second == first;
      });
    };
    return even(places, treatments * treatments) &&
           (treatments == 1 || even(follows, treatments * (treatments - 1)));
  }
};

TEST(TrialOrder, WilliamsRowsBalancePositionAndCarryover) {
  for (std::size_t treatments = 1; treatments <= 9; ++treatments) {
    const auto rows = WilliamsRows(treatments);
    EXPECT_EQ(rows.size(), treatments % 2 == 0 || treatments == 1 ? treatments : 2 * treatments);
    Counts counts;
    for (const auto& row : rows) counts.Add(row);
    EXPECT_TRUE(counts.AreBalanced(treatments)) << treatments;
  }
}

// three conditions have six rows: six participants are balanced in every repetition
TEST(TrialOrder, IsBalancedAcrossParticipants) {
  const Study study = ExampleStudy();
  for (int repetition = 1; repetition <= 2; ++repetition) {
    Counts counts;
    for (int participant = 0; participant < 6; ++participant) {
      std::vector<std::size_t> row;
      for (const PlannedTrial& trial : TrialsOf(study, participant)) {
        if (trial.block == 1 && trial.repetition == repetition) row.push_back(trial.condition);
      }
      counts.Add(row);
    }
    EXPECT_TRUE(counts.AreBalanced(3)) << repetition;
  }
}

TEST(TrialOrder, NumbersRevealOnlyTheOrder) {
  const std::vector<PlannedTrial> trials = TrialsOf(ExampleStudy(), 3);
  ASSERT_EQ(trials.size(), 7U);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    EXPECT_EQ(trials[i].number, static_cast<int>(i) + 1);
  }
  EXPECT_EQ(trials[0].block, 0U);
}

TEST(TrialOrder, DependsOnlyOnTheSeed) {
  Study study = ExampleStudy();
  const auto conditions = [](const Study& of) {
    std::vector<std::size_t> all;
    for (int participant = 0; participant < 6; ++participant) {
      for (const PlannedTrial& trial : TrialsOf(of, participant)) all.push_back(trial.condition);
    }
    return all;
  };
  const auto first = conditions(study);
  EXPECT_EQ(conditions(study), first);
  study.seed = 6;
  EXPECT_NE(conditions(study), first);
}

TEST(TrialOrder, PseudonymsDifferAndRevealNoOrder) {
  Study study = ExampleStudy();
  study.participants = 60;
  const std::vector<std::string> names = PseudonymsOf(study);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 60U);
  EXPECT_FALSE(std::ranges::is_sorted(names));
  for (const std::string& name : names) {
    EXPECT_EQ(name.size(), 3U);
    EXPECT_EQ(name[0], 'P');
  }
}

}  // namespace
}  // namespace tandem
