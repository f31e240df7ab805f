#include "app/stability/report/chosen_cells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collab/coupling/coupling_law.h"
#include "tests/app/stability/report/made_results.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::ReplaceInCase;
using testing::TwentyCells;

void MakeDefault(CellRecord& record) {
  const std::string& text = record.cell.case_json;
  const std::size_t from = text.find(R"({"name":"constant")");
  const std::size_t to = text.find("}}", from) + 2;
  ReplaceInCase(
      record, text.substr(from, to - from),
      R"({"name":")" + std::string(DefaultLaw()->name()) + R"(","ratio":1,"gate":false})");
}

std::string WhyOf(const std::vector<ChosenCell>& chosen, std::size_t number) {
  for (const ChosenCell& cell : chosen) {
    if (cell.number == number) return cell.why;
  }
  return "not chosen";
}

Results WithDefaults() {
  Results results = TwentyCells();
  for (const std::size_t number : {0U, 1U, 5U, 6U, 10U}) MakeDefault(results.records.at(number));
  results.records.at(1).outcome.result.metrics.tail_rms = 9e-4;
  results.records.at(6).outcome.result.metrics.generated_J = 2e-4;
  results.records.at(10).outcome.result.metrics.peak_apart = 0.1;
  ReplaceInCase(results.records.at(5), "free", "slot");
  results.records.at(4).cell.expect = Expectation::kUnstable;
  return results;
}

TEST(ChosenCells, AreTheWorstOfTheDefaultLawTheControlsAndOneOfEachScene) {
  const std::vector<ChosenCell> chosen = ChooseCells(WithDefaults(), 12);
  EXPECT_THAT(WhyOf(chosen, 1), HasSubstr("worst tail"));
  EXPECT_THAT(WhyOf(chosen, 6), HasSubstr("most energy"));
  EXPECT_THAT(WhyOf(chosen, 10), HasSubstr("farthest apart"));
  EXPECT_THAT(WhyOf(chosen, 4), HasSubstr("control"));
  EXPECT_THAT(WhyOf(chosen, 5), HasSubstr("slot"));
  // the one of 100 ms among those of scene free
  EXPECT_THAT(WhyOf(chosen, 6), HasSubstr("one of scene free"));
  // 30 N/m, of a boundary of 42 N/m
  EXPECT_THAT(WhyOf(chosen, 16), HasSubstr("nearest below the boundary"));
  EXPECT_LE(chosen.size(), 7U);
}

TEST(ChosenCells, BeginWithCellsThatContradictTheClaim) {
  Results results = WithDefaults();
  CellRecord& record = results.records.at(0);
  record.cell.expect = Expectation::kStable;
  record.outcome.result.verdict = Verdict::kUnstable;
  const std::vector<ChosenCell> chosen = ChooseCells(results, 3);
  ASSERT_EQ(chosen.size(), 3U);
  EXPECT_EQ(chosen[0].number, 0U);
  EXPECT_THAT(chosen[0].why, HasSubstr("expected stable, but unstable"));
}

TEST(ChosenCells, OmitCellsThatCouldNotRun) {
  Results results = WithDefaults();
  results.records.at(1).outcome.result.fault = Error{"loops did not close"};
  EXPECT_EQ(WhyOf(ChooseCells(results, 12), 1), "not chosen");
}

}  // namespace
}  // namespace tandem
