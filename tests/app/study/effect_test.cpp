#include "app/study/effect.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/study/example_study.h"

namespace tandem {
namespace {

using testing::ExampleStudy;

// The numbers are from tables of Student's distribution.
TEST(Effect, QuantilesMatchTheTables) {
  EXPECT_NEAR(StudentT975(1), 12.706, 1e-3);
  EXPECT_NEAR(StudentT975(9), 2.262, 1e-3);
  EXPECT_NEAR(StudentT975(40), 2.0211, 2e-4);
  EXPECT_NEAR(StudentT975(120), 1.9799, 2e-4);
}

// 2, 4, 6: mean 4, deviation 2, half of the interval 4.303 x 2 / sqrt(3) = 4.969
TEST(Effect, ConfidenceIntervalIsStudents) {
  const MeanInterval interval = IntervalOf({2, 4, 6});
  EXPECT_EQ(interval.count, 3);
  EXPECT_NEAR(interval.mean, 4, 1e-12);
  EXPECT_NEAR(interval.deviation, 2, 1e-12);
  EXPECT_NEAR(interval.high - interval.mean, 4.969, 1e-3);
  EXPECT_TRUE(std::isnan(IntervalOf({3}).low));
}

/// Returns rows of trials that are all done: a path of 10 mm times the participant, 5 mm more when
/// far, 1 mm more in a second repetition, and effort 2 or 6.
std::vector<ResultRow> PlantedRows(const Study& study) {
  std::vector<ResultRow> rows;
  const std::vector<std::string> names = PseudonymsOf(study);
  for (int participant = 0; participant < study.participants; ++participant) {
    for (const PlannedTrial& plan : TrialsOf(study, participant)) {
      ResultRow& row = rows.emplace_back();
      row.participant = names[static_cast<std::size_t>(participant)];
      row.plan = plan;
      row.logged.state = TrialState::kDone;
      const bool far = study.conditions[plan.condition].name == "far";
      row.logged.measures.path_mm =
          10 * (participant + 1) + (far ? 5 + participant % 2 : 0) + plan.repetition;
      if (study.blocks[plan.block].practice) row.logged.measures.path_mm = 1e6;
      row.logged.answers["effort"] = far ? "6" : "2";
    }
  }
  return rows;
}

const MeasureEffect& Of(const std::vector<MeasureEffect>& effects, const std::string& measure) {
  return *std::ranges::find(effects, measure, &MeasureEffect::measure);
}

// far adds 5 mm to three participants and 6 mm to the other three: mean 5.5, deviation sqrt(0.3);
// participants differ by 10 mm each, which pairing takes away
TEST(Effect, FindsAPlantedDifferenceWithinParticipants) {
  const Study study = ExampleStudy();
  const std::vector<MeasureEffect> effects = EffectsOf(study, PlantedRows(study));
  const MeasureEffect& path = Of(effects, "path_mm");
  EXPECT_EQ(study.conditions[path.reference].name, "near");
  ASSERT_EQ(path.conditions.size(), 3U);
  const ConditionEffect& far = path.conditions[1];
  EXPECT_EQ(far.level.count, 6);
  EXPECT_NEAR(far.difference.mean, 5.5, 1e-9);
  EXPECT_NEAR(far.effect_size, 5.5 / std::sqrt(0.3), 1e-9);
  EXPECT_NEAR(far.difference.high - 5.5, 2.571 * std::sqrt(0.3 / 6), 1e-3);
  // near: 10 to 60 mm and the mean repetition, 1.5
  EXPECT_NEAR(path.conditions[0].level.mean, 36.5, 1e-9);
  EXPECT_NEAR(path.conditions[2].difference.mean, 0, 1e-9);
  EXPECT_NEAR(Of(effects, "answer_effort").conditions[1].difference.mean, 4, 1e-9);
}

TEST(Effect, OmitsLostTrialsAndMissingValues) {
  const Study study = ExampleStudy();
  std::vector<ResultRow> rows = PlantedRows(study);
  for (ResultRow& row : rows) {
    if (row.plan.repetition == 2) {
      row.logged.state = TrialState::kLost;
      row.logged.measures.path_mm = 1e6;
    }
  }
  const std::vector<MeasureEffect> effects = EffectsOf(study, rows);
  EXPECT_NEAR(Of(effects, "path_mm").conditions[0].level.mean, 36, 1e-9);
  EXPECT_EQ(std::ranges::count(effects, "completion_s", &MeasureEffect::measure), 0);
}

TEST(Effect, NonFiniteNumberIsNullInJson) {
  const Study study = ExampleStudy();
  std::vector<ResultRow> rows = PlantedRows(study);
  std::erase_if(rows, [&rows](const ResultRow& row) {
    return row.participant != rows.front().participant;
  });
  const auto json = nlohmann::json::parse(EffectsJson(study, EffectsOf(study, rows)));
  ASSERT_FALSE(json.empty());
  EXPECT_EQ(json[0].at("reference"), "near");
  EXPECT_TRUE(json[0].at("conditions")[0].at("difference").is_null());
  EXPECT_TRUE(json[0].at("conditions")[1].at("low").is_null());
}

}  // namespace
}  // namespace tandem
