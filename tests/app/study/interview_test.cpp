#include "app/study/interview.h"

#include <array>
#include <cstdlib>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include "tests/app/study/example_study.h"

namespace tandem {
namespace {

using testing::ExampleStudy;
using ::testing::HasSubstr;

/// A terminal at which a text was typed before.
class Typed {
 public:
  explicit Typed(const std::string& text) {
    EXPECT_EQ(pipe(ends_.data()), 0);
    EXPECT_EQ(write(ends_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    close(ends_[1]);
    out_ = open_memstream(&shown_, &size_);
  }
  ~Typed() {
    close(ends_[0]);
    std::fclose(out_);
    std::free(shown_);
  }
  Interview interview() { return {ends_[0], out_}; }
  std::string shown() {
    std::fflush(out_);
    return {shown_, size_};
  }

 private:
  std::array<int, 2> ends_{};
  char* shown_ = nullptr;
  std::size_t size_ = 0;
  std::FILE* out_ = nullptr;
};

TEST(Interview, RepeatsTheQuestionUntilTheAnswerIsValid) {
  Typed typed("8\n\nseven\n 7 \n");
  EXPECT_EQ(typed.interview().Ask(ExampleStudy().questions[0]), "7");
  EXPECT_THAT(typed.shown(), HasSubstr("a number from 1 (easy) to 7 (hard)"));
  EXPECT_THAT(typed.shown(), HasSubstr("'seven' is not an answer"));
}

TEST(Interview, ChoiceIsGivenByNumberOrText) {
  const StudyQuestion question = ExampleStudy().questions[1];
  EXPECT_EQ(AnswerOf(question, "2"), "no");
  EXPECT_EQ(AnswerOf(question, "YES"), "yes");
  EXPECT_FALSE(AnswerOf(question, "3"));
  EXPECT_FALSE(AnswerOf(question, "0"));
  EXPECT_FALSE(AnswerOf(question, ""));
}

TEST(Interview, TextIsKeptWithoutControlCharacters) {
  Typed typed("  well\x1b[2J then\n");
  EXPECT_EQ(typed.interview().Ask(ExampleStudy().questions[2]), "well[2J then");
  EXPECT_FALSE(AnswerOf(ExampleStudy().questions[2], std::string(501, 'x')));
}

// A participant who presses Enter twice has not answered the question that comes then.
TEST(Interview, DiscardsTerminalInputFromBeforeTheQuestion) {
  const int keyboard = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(keyboard, 0);
  ASSERT_EQ(grantpt(keyboard), 0);
  ASSERT_EQ(unlockpt(keyboard), 0);
  const int terminal = open(ptsname(keyboard), O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  const auto type = [&](const std::string& text) {
    EXPECT_EQ(write(keyboard, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    pollfd typed{terminal, POLLIN, 0};
    EXPECT_EQ(poll(&typed, 1, 10'000), 1);
  };
  Interview interview(terminal, stdout);
  type("\n\n");
  interview.ForgetTyped();
  type("7\n");
  EXPECT_EQ(interview.Line(), "7");
  close(terminal);
  close(keyboard);
}

TEST(Interview, KeepsPipedInputFromBeforeTheQuestion) {
  Typed typed("7\n");
  Interview interview = typed.interview();
  interview.ForgetTyped();
  EXPECT_EQ(interview.Line(), "7");
}

TEST(Interview, ReportsTheEndOfInput) {
  Typed typed("maybe\n");
  EXPECT_FALSE(typed.interview().AskForWord("Do you agree?", {"yes", "no"}));
}

}  // namespace
}  // namespace tandem
