#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/source_comments.h"
#include "tests/architecture/tree_files.h"

// Tests what docs/conventions.md asks of comments, as far as a program can read them.
namespace tandem {
namespace {

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
  for (testing::SourceComment& comment : testing::CommentsOf(source)) {
    std::ranges::replace(comment.text, '\n', ' ');
    comment.text.erase(0, comment.text.find_first_not_of(' '));
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

TEST(Comments, HaveNoRefusedWords) {
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
  EXPECT_THAT(testing::CommentsOf(source), ::testing::SizeIs(4));
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
