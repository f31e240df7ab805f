#include "app/stability/report/seed_spread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/stability/report/made_results.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::ReplaceInCase;
using testing::TwentyCells;

TEST(SeedSpread, HasARowForEachCaseThatWasRunWithSeveralSeeds) {
  Results results = TwentyCells();
  const double growths[] = {-0.5, 0.3, -0.1};
  for (std::size_t i = 0; i < 3; ++i) {
    CellRecord record = results.records.at(6);  // 30 N/m at 100 ms
    record.cell.number = 20 + i;
    ReplaceInCase(record, "\"seed\":7", "\"seed\":" + std::to_string(70 + i));
    CaseResult& result = record.outcome.result;
    result.metrics.growth = growths[i];
    result.metrics.peak_apart = 1e-3 * static_cast<double>(1 + i);
    result.metrics.tail_rms = 1e-3 * static_cast<double>(3 - i);
    result.metrics.peak_force = 2;
    if (i == 1) result.verdict = Verdict::kUnstable;
    if (i == 2) result.verdict = Verdict::kUndecided;
    results.records.emplace(record.cell.number, record);
  }
  results.records.erase(6);
  const std::optional<ReportTable> table = SeedSpreadOf(results);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->title, "Spread over seeds of made");
  ASSERT_EQ(table->rows.size(), 1U);
  EXPECT_EQ(table->rows[0].size(), table->columns.size());
  EXPECT_THAT(table->rows[0], ElementsAre("20", "free", "2", "heavy", "100", "clean", "1000",
                                          HasSubstr("constant 30 N/m"), "kick", "3", "1", "1", "1",
                                          "-0.5", "-0.1", "0.3", "3", "1", "2", "3", "2"));
}

TEST(SeedSpread, IsEmptyWithoutRepeatedCases) {
  EXPECT_FALSE(SeedSpreadOf(TwentyCells()));
}

}  // namespace
}  // namespace tandem
