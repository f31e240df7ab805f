#include "app/study/study_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/study/example_study.h"

namespace tandem {
namespace {

using testing::ExampleStudy;
using testing::ExampleStudyText;
using ::testing::HasSubstr;

/// Returns the refusal of the example with one text in place of another.
std::string RefusalOf(const std::string& instead_of, const std::string& text) {
  std::string study = ExampleStudyText();
  const std::size_t at = study.find(instead_of);
  if (at == std::string::npos) return "the example has no " + instead_of;
  study.replace(at, instead_of.size(), text);
  const Result<Study> read = ParseStudy(study, "s.json");
  return read ? "" : read.error().what;
}

TEST(StudyFile, IsReadInFull) {
  const Study study = ExampleStudy();
  EXPECT_EQ(study.participants, 6);
  ASSERT_EQ(study.conditions.size(), 3U);
  EXPECT_EQ(study.conditions[1].delay_ms, 300);
  EXPECT_EQ(study.conditions[1].gains.constant_stiffness, 80);
  EXPECT_FALSE(study.conditions[1].gate);
  EXPECT_EQ(study.conditions[2].burst_loss, 0.9);
  EXPECT_TRUE(study.blocks[0].practice);
  EXPECT_EQ(study.blocks[1].conditions, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(study.tasks[0].success.moved_mm, 100);
  EXPECT_EQ(study.questions[1].choices, (std::vector<std::string>{"yes", "no"}));
}

TEST(StudyFile, ErrorsNameTheirPosition) {
  EXPECT_THAT(RefusalOf("\"delay_ms\": 300", "\"delay_ms\": 3000"),
              HasSubstr("conditions[1].delay_ms"));
  EXPECT_THAT(RefusalOf("\"jitter_ms\"", "\"jitter\""), HasSubstr("jitter_ms"));
  EXPECT_THAT(RefusalOf("[\"near\", \"far\", \"bursty\"]", "[\"near\", \"fare\"]"),
              HasSubstr("expected one of near, far, bursty"));
  EXPECT_THAT(RefusalOf("[\"near\", \"far\", \"bursty\"]", "[\"near\", \"near\"]"),
              HasSubstr("is given twice"));
  EXPECT_THAT(RefusalOf("\"kind\": \"text\"", "\"kind\": \"words\""),
              HasSubstr("questions[2].kind: expected choice, scale or text"));
  EXPECT_THAT(RefusalOf("\"constant_stiffness\"", "\"linear_stiffness\""),
              HasSubstr("conditions[1].gains.linear_stiffness"));
  EXPECT_THAT(RefusalOf("\"moved_mm\": 100, ", ""), HasSubstr("success.time_s"));
  EXPECT_THAT(RefusalOf("\"example\"", "\"an example\""), HasSubstr("name: expected a word"));
  EXPECT_THAT(RefusalOf("\"key\": \"late\"", "\"key\": \"effort\""), HasSubstr("twice"));
}

}  // namespace
}  // namespace tandem
