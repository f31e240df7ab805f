#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/sweep/results_file.h"
#include "collab/lab/sweep/sweep_summary.h"

// Runs the presets that are shipped, the two long ones by a shard. paper.json is in
// tests/app/stability/cli/stability_run_test.cpp, adversarial.json in lab_scenes_test.cpp.
// presets.sh runs all cells of the long ones; its last result is in docs/results.
namespace tandem {
namespace {

const std::filesystem::path kPresets = std::filesystem::path(TANDEM_SCENES) / "stability";

/// Runs the cells of a preset that a shard has.
Results RunPreset(const std::string& name, const Shard& shard = {}) {
  const Result<Sweep> sweep =
      LoadSweep(kPresets / name, [](const std::string& text, const std::string& place) {
        const Result<LabCase> test = ParseCase(text, place);
        return test ? std::nullopt : std::optional<Error>(test.error());
      });
  EXPECT_TRUE(sweep) << sweep.error().what;
  Results results;
  if (!sweep) return results;
  std::vector<SweepCell> cells;
  std::map<std::string, LabScene> scenes;
  for (const SweepCell& cell : sweep->cells) {
    if (!shard.Has(cell)) continue;
    const LabCase test = *ParseCase(cell.case_json, "cell");
    if (!scenes.contains(test.scene)) scenes.emplace(test.scene, *LoadLabScene(test, kPresets));
    cells.push_back(cell);
  }
  RunCells(
      cells, 2,
      [&scenes](const SweepCell& cell) {
        const LabCase test = *ParseCase(cell.case_json, "cell");
        const LabScene& scene = scenes.at(test.scene);
        CellOutcome outcome;
        outcome.predicted = Predict(FittedTo(scene.inertia(), test), scene.inertia());
        outcome.result = RunCase(test, scene);
        return outcome;
      },
      [&results](const SweepCell& cell, const CellOutcome& outcome) {
        results.records.emplace(cell.number, CellRecord{cell, outcome});
      });
  return results;
}

std::string TextOf(const CellRecord& record) {
  const Metrics& metrics = record.outcome.result.metrics;
  return "cell " + std::to_string(record.cell.number) + ": " +
         NameOf(record.outcome.result.verdict) + ", growth " + std::to_string(metrics.growth) +
         " /s, tail " + std::to_string(1e3 * metrics.tail_rms) + " mm/s; " + record.cell.case_json;
}

void ExpectAllRows(const Results& results) {
  const SweepSummary summary = Summarize(results);
  for (const SweepRow& row : summary.rows) EXPECT_TRUE(row.pass) << row.name << " " << row.value;
  for (const std::size_t cell : summary.failing) ADD_FAILURE() << TextOf(results.records.at(cell));
}

TEST(DefaultPreset, IsStableInEveryCell) {
  const Results results = RunPreset("default.json");
  ASSERT_EQ(results.records.size(), 80U);
  ExpectAllRows(results);
}

// Hands hold a part apart over a line that loses samples. Each change of stiffness moves the part,
// and none moves it so that it is felt (docs/decisions/0050-links-that-last.md).
TEST(DefaultPreset, OpposingHandsFeelNoPacketLossWithAnySeed) {
  LabCase test = *ParseCase(
      R"({"network": "lossy", "publish_hz": 100, "motion": "hold", "delay_s": 0.02})", "case");
  const LabScene scene = *LoadLabScene(test, kPresets);
  for (test.seed = 1; test.seed <= 8; ++test.seed) {
    for (const double delay_s : {0.02, 0.05}) {
      SCOPED_TRACE(std::to_string(test.seed) + " at " + std::to_string(delay_s) + " s");
      test.delay_s = delay_s;
      const CaseResult result = RunCase(test, scene);
      ASSERT_FALSE(result.fault) << result.fault->what;
      EXPECT_EQ(result.verdict, Verdict::kStable);
      EXPECT_LE(result.metrics.generated_J, 1e-3);
      EXPECT_LT(result.metrics.tail_rms, 0.5e-3);
    }
  }
}

TEST(AcceptancePreset, PassesAllRowsInOneShardOfForty) {
  const Results results = RunPreset("acceptance.json", {1, 40});
  EXPECT_GE(results.records.size(), 14U);
  ExpectAllRows(results);
}

TEST(MapPreset, HasNoUnstablePredictedStableCellInOneShardOfForty) {
  const Results results = RunPreset("map.json", {1, 40});
  EXPECT_GE(results.records.size(), 13U);
  ExpectAllRows(results);
}

TEST(SinglePresets, AreStable) {
  for (const char* name : {"knock.json", "live.json"}) {
    SCOPED_TRACE(name);
    const LabCase test = *LoadCase(kPresets / name);
    const CaseResult result = RunCase(test, *LoadLabScene(test, kPresets));
    ASSERT_FALSE(result.fault) << result.fault->what;
    EXPECT_EQ(result.verdict, Verdict::kStable)
        << result.metrics.growth << " " << result.metrics.tail_rms;
    EXPECT_LE(result.metrics.generated_J, 1e-3);
  }
}

TEST(NetworksPreset, PassesItsRow) {
  const Results results = RunPreset("networks.json");
  EXPECT_EQ(results.records.size(), 42U);
  ExpectAllRows(results);
}

// A preset that is added is added here, or to one of the tests named above.
TEST(OffsetPreset, HasNoUnstablePredictedStableCellInOneShardOfEight) {
  const Results results = RunPreset("offset.json", {1, 8});
  ExpectAllRows(results);
}

TEST(Presets, AreAllRunByATest) {
  std::set<std::string> presets;
  for (const auto& entry : std::filesystem::directory_iterator(kPresets)) {
    if (entry.path().extension() != ".json") continue;
    presets.insert(entry.path().filename().string());
  }
  for (const char* scene : {"ball.json", "free.json", "slot.json", "wall.json"}) {
    EXPECT_EQ(presets.erase(scene), 1U) << scene;
  }
  EXPECT_EQ(presets, (std::set<std::string>{"acceptance.json", "adversarial.json", "default.json",
                                            "knock.json", "live.json", "map.json", "networks.json",
                                            "offset.json", "paper.json"}));
}

}  // namespace
}  // namespace tandem
