#include "engine/contact/region_budget.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr std::size_t kCandidates = 8000;

/// A pair whose regions hold for `frames`; gives the regions made in a frame after some time.
double MadeAtRest(RegionBudget& budget, double frames) {
  double known = 0;
  double made = 0;
  for (int frame = 0; frame < 400; ++frame) {
    double served = 0;
    for (std::uint32_t point = 0; point < kCandidates; ++point) served += budget.Serves(point);
    const auto candidates = kCandidates;
    const double lost = known / frames;
    const double unknown = served - (known - lost);
    made = unknown / static_cast<double>(budget.OneIn(candidates));
    known = std::min(served, known - lost + made);
    budget.Count(candidates, static_cast<std::size_t>(kCandidates - known),
                 static_cast<std::size_t>(known), static_cast<std::size_t>(made));
  }
  return made;
}

TEST(RegionBudget, MakesFewWhereTheyDoNotHoldAndNeverMoreThanAFrameBears) {
  RegionBudget budget;
  EXPECT_LE(kCandidates / budget.OneIn(kCandidates), 128U) << "a sudden contact";
  EXPECT_LT(MadeAtRest(budget, 1.0), 20);
  EXPECT_FALSE(budget.Serves(1));
  // motion slows down
  EXPECT_GT(MadeAtRest(budget, 60.0), 100);
  EXPECT_TRUE(budget.Serves(1));
  // and is fast again
  EXPECT_LT(MadeAtRest(budget, 1.0), 20);
}

TEST(RegionBudget, GivesAllOfAFewTheirRegions) {
  RegionBudget budget;
  EXPECT_EQ(budget.OneIn(100), 1U);
  budget.Count(100, 50, 50, 50);
  EXPECT_EQ(budget.OneIn(110), 1U);
}

}  // namespace
}  // namespace tandem
