#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

// Tests what docs/conventions.md asks of comments, as far as a program can read them.
namespace tandem {
namespace {

/// A comment of a source file. Consecutive lines of // are one comment, and so is a trailing
/// comment with the lines below it that begin in the same column.
struct SourceComment {
  std::size_t line = 0;  // number of its first line
  std::string text;      // its lines without slashes, a space between two
};

/// Reads the comments of C++ and IDL. Slashes in literals are none.
class CommentReader {
 public:
  explicit CommentReader(std::string_view source) : source_(source) {}

  std::vector<SourceComment> Read() {
    while (at_ < source_.size()) {
      if (Begins("//")) {
        TakeComment();
      } else if (Begins("/*")) {
        SkipPast("*/", 2);
      } else if (Begins("R\"")) {
        const std::size_t open = source_.find('(', at_);
        if (open == std::string_view::npos) break;
        SkipPast(")" + std::string(source_.substr(at_ + 2, open - at_ - 2)) + "\"", open + 1 - at_);
      } else if (source_[at_] == '"' || (source_[at_] == '\'' && !IsSeparator())) {
        SkipLiteral();
      } else {
        Step();
      }
    }
    return std::move(comments_);
  }

 private:
  bool Begins(std::string_view with) const { return source_.substr(at_).starts_with(with); }
  /// Returns whether the quote here stands between digits, as in 1'000.
  bool IsSeparator() const {
    return at_ > 0 && std::isalnum(static_cast<unsigned char>(source_[at_ - 1])) != 0;
  }
  void Step() {
    if (source_[at_] == '\n') {
      ++line_;
      line_begin_ = at_ + 1;
    }
    ++at_;
  }
  void SkipPast(std::string_view end, std::size_t from) {
    const std::size_t found = source_.find(end, at_ + from);
    const std::size_t past = found == std::string_view::npos ? source_.size() : found + end.size();
    while (at_ < past) Step();
  }
  void SkipLiteral() {
    const char quote = source_[at_];
    for (Step(); at_ < source_.size() && source_[at_] != quote; Step()) {
      if (source_[at_] == '\\' && at_ + 1 < source_.size()) Step();
    }
    if (at_ < source_.size()) Step();
  }
  void TakeComment() {
    const std::size_t column = at_ - line_begin_;
    const bool is_alone = source_.find_first_not_of(' ', line_begin_) == at_;
    const std::size_t text = std::min(source_.find_first_not_of('/', at_), source_.size());
    const std::size_t end = std::min(source_.find('\n', at_), source_.size());
    std::string_view words = source_.substr(text, end - text);
    words.remove_prefix(std::min(words.find_first_not_of(' '), words.size()));
    if (is_alone && !comments_.empty() && last_line_ + 1 == line_ &&
        (last_is_alone_ || last_column_ == column)) {
      std::string& before = comments_.back().text;
      before += (before.empty() ? "" : " ") + std::string(words);
    } else {
      comments_.push_back({line_, std::string(words)});
      last_is_alone_ = is_alone;
    }
    last_line_ = line_;
    last_column_ = column;
    at_ = end;
  }

  std::string_view source_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t line_begin_ = 0;
  std::vector<SourceComment> comments_;
  std::size_t last_line_ = 0;    // last line of the newest comment
  std::size_t last_column_ = 0;  // column in which that line begins
  bool last_is_alone_ = false;   // no code stands before the newest comment
};

/// Returns the words of a text in small letters.
std::vector<std::string> SmallWordsOf(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalpha(byte) != 0 || c == '_') {
      words.back() += static_cast<char>(std::tolower(byte));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

/// Returns whether a text begins with a word that has no subject before it. A program cannot tell
/// whether a sentence follows, so that questions are refused as well.
bool BeginsAsAFragment(const std::string& text) {
  constexpr std::array<std::string_view, 4> kFragments{"of", "what", "who", "whether"};
  if (text.empty() || std::isalpha(static_cast<unsigned char>(text.front())) == 0) return false;
  return std::ranges::find(kFragments, SmallWordsOf(text).front()) != kFragments.end();
}

/// Returns whether a text has a word of an earlier dialect of this project. The field's words are
/// pre-filter, unattended run and violation.
bool HasAPrivateWord(const std::string& text) {
  constexpr std::array<std::string_view, 6> kPrivate{"sieve",   "sieves",   "errand",
                                                     "errands", "breakage", "breakages"};
  return std::ranges::any_of(SmallWordsOf(text), [&](const std::string& word) {
    return std::ranges::find(kPrivate, word) != kPrivate.end();
  });
}

/// Returns "path:line: text" for each comment of a source that `is_wrong` refuses.
template <typename IsWrong>
std::vector<std::string> WrongComments(const std::string& path, const std::string& source,
                                       const IsWrong& is_wrong) {
  std::vector<std::string> wrong;
  for (const SourceComment& comment : CommentReader(source).Read()) {
    if (!is_wrong(comment.text)) continue;
    wrong.push_back(path + ":" + std::to_string(comment.line) + ": " + comment.text);
  }
  return wrong;
}

/// Expects that `is_wrong` refuses no comment of this tree, and names each that it refuses.
template <typename IsWrong>
void ExpectNoneInTheTree(const IsWrong& is_wrong) {
  std::size_t comments = 0;
  const auto counted = [&](const std::string& text) {
    ++comments;
    return is_wrong(text);
  };
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    const std::string type = file.extension();
    if (type != ".h" && type != ".cpp" && type != ".idl") continue;
    for (const std::string& wrong :
         WrongComments(file.string(), testing::TreeText(file), counted)) {
      ADD_FAILURE() << wrong;
    }
  }
  EXPECT_GT(comments, 5000U);
}

TEST(Comments, BeginWithASubjectOrAVerb) {
  ExpectNoneInTheTree(BeginsAsAFragment);
}

TEST(Comments, HaveNoWordsOfAnEarlierDialect) {
  ExpectNoneInTheTree(HasAPrivateWord);
}

TEST(Comments, FragmentsAreFound) {
  const std::string source =
      "//\n"
      "// Of the body.\n"
      "int a = 0;  // what it was\n"
      "/// Who comes\n"
      "/// late.\n"
      "\n"
      "  //whether it is so\n"
      "int b;  // m; of a body\n"
      "        // Of a second line\n"
      "// of another comment: what is that?\n";
  EXPECT_THAT(WrongComments("a/b.h", source, BeginsAsAFragment),
              ::testing::ElementsAre("a/b.h:1: Of the body.", "a/b.h:3: what it was",
                                     "a/b.h:4: Who comes late.", "a/b.h:7: whether it is so",
                                     "a/b.h:10: of another comment: what is that?"));
}

TEST(Comments, SentencesAndLiteralsAreNoFragments) {
  const std::string source =
      "/// Returns the place\n"
      "/// of a body, and\n"
      "/// what it is.\n"
      "const char* url = \"http://a\\\"//of\";  // Offset; whatever it is\n"
      "const char* raw = R\"x(\n"
      "// What \" is no comment )\" )x\";\n"
      "char c = '\"'; int n = 1'000;  // whoever reads\n"
      "/* // who */ // `of` is a name\n"
      "/* of\n"
      "// what */\n";
  EXPECT_THAT(WrongComments("a.cpp", source, BeginsAsAFragment), ::testing::IsEmpty());
  EXPECT_THAT(CommentReader(source).Read(), ::testing::SizeIs(4));
}

TEST(Comments, PrivateWordsAreFound) {
  const std::string source =
      "int sieve;  // a sieved point, broken\n"
      "// Runs the\n"
      "// Errand's end.\n"
      "int b;  // two breakages\n";
  EXPECT_THAT(WrongComments("a.idl", source, HasAPrivateWord),
              ::testing::ElementsAre("a.idl:2: Runs the Errand's end.", "a.idl:4: two breakages"));
}

}  // namespace
}  // namespace tandem
