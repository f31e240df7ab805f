#include "collab/lab/sweep/sweep_summary.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/collab/lab/sweep/fake_cells.h"

namespace tandem {
namespace {

// Returns four cells of the default law, one of half its stiffness, and one control.
Results SixCells() {
  const ScratchFolder folder;
  const auto file = folder.Write("sweep.json", R"({"name": "six", "blocks": [
      {"expect": "stable", "delay_s": [0.02, 0.1, 0.3, 1]}, {"ratio": 0.5},
      {"expect": "unstable", "law": "constant"}]})");
  const Sweep sweep = *LoadSweep(file, [](const std::string&, const std::string&) {
    return std::nullopt;
  });
  Results results{testing::HeaderFor(sweep), {}};
  for (const SweepCell& cell : sweep.cells) {
    CellRecord record{cell, {}};
    record.outcome.result.verdict = Verdict::kStable;
    record.outcome.result.digest = 77 + cell.number;
    record.outcome.result.metrics.generated_J = 1e-5 * static_cast<double>(cell.number);
    record.outcome.result.metrics.tail_rms = 1e-4 * static_cast<double>(cell.number);
    record.outcome.result.simulated_s = 12;
    record.outcome.cpu_s = 0.04;
    record.outcome.predicted =
        Prediction{90, 100.0 + static_cast<double>(cell.number)};  // the first: not
    results.records.emplace(cell.number, record);
  }
  results.records.at(5).outcome.result.verdict = Verdict::kUnstable;
  results.records.at(5).outcome.predicted.reset();
  return results;
}

const SweepRow& Row(const SweepSummary& summary, const std::string& name) {
  for (const SweepRow& row : summary.rows) {
    if (row.name.find(name) != std::string::npos) return row;
  }
  static const SweepRow none;
  ADD_FAILURE() << name;
  return none;
}

TEST(SweepSummary, CountsTheAcceptanceTablesRows) {
  const Results results = SixCells();
  const SweepSummary summary = Summarize(results);
  EXPECT_TRUE(summary.pass());
  EXPECT_TRUE(summary.failing.empty());
  const auto json = nlohmann::json::parse(JsonOf(summary, 3.5, 4));
  EXPECT_EQ(json["cells"], 6);
  EXPECT_EQ(json["wall_s"], 3.5);
  EXPECT_EQ(json["jobs"], 4);
  EXPECT_EQ(json["digest"], DigestOf(results));
  EXPECT_EQ(json["predicted_stable"], 4);  // 90 < 0.9 of 101 to 104
  EXPECT_EQ(json["predicted_stable_measured_unstable"], 0);
  EXPECT_EQ(json["default_law_cells"], 4);
  EXPECT_EQ(json["default_law_unstable"], 0);
  // the fourth cell's; the fifth has another ratio
  EXPECT_NEAR(json["max_energy_mJ"], 0.03, 1e-12);
  EXPECT_NEAR(json["max_tail_rms_mm_s"], 0.3, 1e-12);
  EXPECT_EQ(json["positive_controls"], 1);
  EXPECT_EQ(json["positive_controls_caught"], 1);
  EXPECT_NEAR(json["free_pair_speed"], 300, 1e-9);
  for (const auto& row : json["rows"]) EXPECT_EQ(row["pass"], true) << row;
}

TEST(SweepSummary, EachRowCanFailAlone) {
  const auto failed = [](const std::string& row, std::size_t cell, auto&& change) {
    Results results = SixCells();
    change(results.records.at(cell).outcome);
    const SweepSummary summary = Summarize(results);
    EXPECT_FALSE(summary.pass()) << row;
    EXPECT_FALSE(Row(summary, row).pass) << row;
    EXPECT_EQ(summary.failing, std::vector<std::size_t>{cell}) << row;
  };
  const auto not_stable = [](CellOutcome& outcome) {
    outcome.result.verdict = Verdict::kUnstable;
  };
  const auto undecided = [](CellOutcome& outcome) {
    outcome.result.verdict = Verdict::kUndecided;
  };
  failed("predicted stable, measured unstable", 4, not_stable);
  failed("predicted stable, undecided", 4, undecided);
  failed("held to be stable", 0, not_stable);
  failed("default law, not stable", 2, not_stable);
  failed("default law, not stable", 2, undecided);
  failed("energy", 1, [](CellOutcome& outcome) {
    outcome.result.metrics.generated_J = 1.01e-3;
  });
  failed("energy", 1, [](CellOutcome& outcome) {
    outcome.result.metrics.generated_J = std::nan("");
  });
  failed("tail", 3, [](CellOutcome& outcome) {
    outcome.result.metrics.tail_rms = 2e-3;
  });
  failed("controls", 5, [](CellOutcome& outcome) {
    outcome.result.verdict = Verdict::kStable;
  });
  failed("could not be run", 4, [](CellOutcome& outcome) {
    outcome.result.fault = Error{"no"};
  });
  failed("wall between", 4, [](CellOutcome& outcome) {
    outcome.result.metrics.trapped_frames = 1;
  });
}

// A cell that decays and is not at rest contradicts no prediction.
TEST(SweepSummary, UndecidedCellsRefuteNoPrediction) {
  Results results = SixCells();
  results.records.at(4).outcome.result.verdict = Verdict::kUndecided;
  const SweepSummary summary = Summarize(results);
  EXPECT_TRUE(Row(summary, "predicted stable, measured unstable").pass);
  EXPECT_FALSE(Row(summary, "predicted stable, undecided").pass);
  const auto json = nlohmann::json::parse(JsonOf(summary, 1, 1));
  EXPECT_EQ(json["predicted_stable_measured_unstable"], 0);
  EXPECT_EQ(json["predicted_stable_undecided"], 1);
  EXPECT_EQ(json["undecided"], 1);
}

TEST(SweepSummary, OmitsRowsWithoutCells) {
  Results results = SixCells();
  results.records = {{4, results.records.at(4)}};
  results.records.at(4).outcome.predicted.reset();
  const SweepSummary summary = Summarize(results);
  EXPECT_EQ(summary.rows.size(), 2U);
  EXPECT_TRUE(summary.pass());
}

}  // namespace
}  // namespace tandem
