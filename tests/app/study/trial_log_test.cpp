#include "app/study/trial_log.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const TrialLogHeader kHeader{"example", "00ff", 5, "1.0", "persons", "participant"};

std::string TextOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class TrialLogTest : public ::testing::Test {
 protected:
  Result<TrialLog> Open(const TrialLogHeader& header = kHeader) {
    return TrialLog::Open(file_, header, 2);
  }

  ScratchFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "trials.jsonl";
};

TEST_F(TrialLogTest, RoundTrips) {
  {
    Result<TrialLog> log = Open();
    ASSERT_TRUE(log) << log.error().what;
    EXPECT_FALSE(log->ConsentOf("P07"));
    EXPECT_FALSE(log->Consent("P07"));
    EXPECT_FALSE(log->Begin("P07", 1));
    TrialMeasures measures;
    measures.path_mm = 12.5;
    EXPECT_FALSE(log->Ran("P07", 1, measures));
    EXPECT_EQ(log->TrialOf("P07", 1).state, TrialState::kRan);
    EXPECT_FALSE(log->Answered("P07", 1, {{"effort", "4"}}));
  }
  const Result<TrialLog> log = Open();
  ASSERT_TRUE(log) << log.error().what;
  EXPECT_TRUE(log->ConsentOf("P07"));
  const LoggedTrial trial = log->TrialOf("P07", 1);
  EXPECT_EQ(trial.state, TrialState::kDone);
  EXPECT_EQ(trial.attempts, 1);
  EXPECT_EQ(trial.measures.path_mm, 12.5);
  EXPECT_TRUE(std::isnan(trial.measures.completion_s));
  EXPECT_EQ(trial.answers.at("effort"), "4");
  EXPECT_EQ(log->TrialOf("P07", 2).state, TrialState::kPlanned);
}

TEST_F(TrialLogTest, InterruptedTrialIsRepeatedOnceThenLost) {
  {
    Result<TrialLog> log = Open();
    ASSERT_TRUE(log);
    EXPECT_FALSE(log->Begin("P07", 1));
  }
  {
    Result<TrialLog> log = Open();
    ASSERT_TRUE(log);
    EXPECT_EQ(log->TrialOf("P07", 1).state, TrialState::kCut);
    EXPECT_FALSE(log->Begin("P07", 1));
  }
  const Result<TrialLog> log = Open();
  ASSERT_TRUE(log);
  EXPECT_EQ(log->TrialOf("P07", 1).state, TrialState::kLost);
  EXPECT_EQ(log->TrialOf("P07", 1).attempts, 2);
}

// A program that is killed leaves a line without an end. Wherever it ends, the log opens and has
// all whole lines.
TEST_F(TrialLogTest, ToleratesATruncatedLastLine) {
  {
    Result<TrialLog> log = Open();
    ASSERT_TRUE(log);
    EXPECT_FALSE(log->Consent("P07"));
    EXPECT_FALSE(log->Begin("P07", 1));
  }
  const std::string whole = TextOf(file_);
  const std::size_t last = whole.rfind('\n', whole.size() - 2) + 1;
  for (std::size_t size = last; size < whole.size(); ++size) {
    std::ofstream(file_, std::ios::trunc) << whole.substr(0, size);
    Result<TrialLog> log = Open();
    ASSERT_TRUE(log) << size << ": " << log.error().what;
    EXPECT_TRUE(log->ConsentOf("P07"));
    EXPECT_EQ(log->TrialOf("P07", 1).state, TrialState::kPlanned);
    EXPECT_FALSE(log->Begin("P07", 1));
    EXPECT_EQ(std::ranges::count(TextOf(file_), '\n'), 3) << size;
  }
}

TEST_F(TrialLogTest, RefusesOtherStudiesAndConcurrentPrograms) {
  Result<TrialLog> log = Open();
  ASSERT_TRUE(log);
  Result<TrialLog> second = Open();
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().what, HasSubstr("another 'tandem study' uses it"));
  { const TrialLog gone = *std::move(log); }
  TrialLogHeader other = kHeader;
  other.study_hash = "00fe";
  const Result<TrialLog> refused = Open(other);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("belongs to another study file"));
  other = kHeader;
  other.mode = "dry run in virtual time";
  ASSERT_FALSE(Open(other));
}

TEST_F(TrialLogTest, NamesADamagedLine) {
  { ASSERT_TRUE(Open()); }
  std::ofstream(file_, std::ios::app) << "{\"event\": \"begun\"}\n";
  const Result<TrialLog> log = Open();
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().what, HasSubstr("trials.jsonl line 2"));
}

TEST_F(TrialLogTest, WithdrawalErasesTheParticipant) {
  Result<TrialLog> log = Open();
  ASSERT_TRUE(log);
  for (const char* who : {"P07", "P12"}) {
    EXPECT_FALSE(log->Consent(who));
    EXPECT_FALSE(log->Begin(who, 1));
  }
  EXPECT_FALSE(log->Withdraw("P07"));
  EXPECT_FALSE(log->Begin("P12", 2));
  const std::string text = TextOf(file_);
  EXPECT_THAT(text, Not(HasSubstr("\"consent\",\"participant\":\"P07\"")));
  EXPECT_THAT(text, Not(HasSubstr("\"begun\",\"participant\":\"P07\"")));
  EXPECT_THAT(text, HasSubstr("\"withdrawn\",\"participant\":\"P07\""));
  EXPECT_TRUE(log->Withdrew("P07"));
  EXPECT_EQ(log->TrialOf("P12", 2).state, TrialState::kCut);
}

}  // namespace
}  // namespace tandem
