#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

// Tests that words of an earlier dialect of this project (refused_words.txt) occur neither in names
// nor in comments, documents and texts to users.
namespace tandem {
namespace {

using Words = std::set<std::string>;

/// A word of a text, in small letters, or a whole name as it is written.
struct PlacedWord {
  std::string word;
  std::size_t line = 0;
};

bool IsLetter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool IsNameCharacter(char c) {
  return c == '_' || std::isalnum(static_cast<unsigned char>(c)) != 0 ||
         static_cast<unsigned char>(c) >= 0x80U;
}

char Small(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

/// Returns the names of a text: each run of letters, digits and _. An option such as --seeds is
/// none.
std::vector<PlacedWord> NamesIn(std::string_view text) {
  std::vector<PlacedWord> names;
  std::size_t line = 1;
  for (std::size_t at = 0; at < text.size();) {
    if (!IsNameCharacter(text[at])) {
      line += text[at] == '\n' ? 1 : 0;
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && IsNameCharacter(text[end])) ++end;
    const bool is_option = at > 0 && text[at - 1] == '-' &&
                           (at < 2 || (!IsNameCharacter(text[at - 2]) && text[at - 2] != ')'));
    if (!is_option) names.push_back({std::string(text.substr(at, end - at)), line});
    at = end;
  }
  return names;
}

/// Returns the words of a name in small letters: kWorstRTTOfPeer has worst, rtt and peer. A word of
/// less than three letters is left out, and so is a name with digits or foreign letters.
std::vector<std::string> WordsOfName(const std::string& name) {
  std::vector<std::string> words;
  if (!std::ranges::all_of(name, [](char c) {
        return c == '_' || IsLetter(c);
      }))
    return words;
  const auto is_capital = [&name](std::size_t i) {
    return i < name.size() && std::isupper(static_cast<unsigned char>(name[i])) != 0;
  };
  std::string word;
  const auto end_word = [&words, &word] {
    if (word.size() >= 3) words.push_back(word);
    word.clear();
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (name[i] == '_') {
      end_word();
      continue;
    }
    const bool after_small = i > 0 && IsLetter(name[i - 1]) && !is_capital(i - 1);
    const bool before_small = i + 1 < name.size() && IsLetter(name[i + 1]) && !is_capital(i + 1);
    if (is_capital(i) && (after_small || before_small)) end_word();
    word += Small(name[i]);
  }
  end_word();
  return words;
}

std::vector<PlacedWord> WordsIn(std::string_view text) {
  std::vector<PlacedWord> words;
  for (const PlacedWord& name : NamesIn(text)) {
    for (std::string& word : WordsOfName(name.word)) {
      words.push_back({std::move(word), name.line});
    }
  }
  return words;
}

/// Returns the lines of a list in this folder, without those that begin with #.
std::vector<std::string> ListLines(const std::string& name) {
  std::vector<std::string> lines;
  std::istringstream in(testing::TreeText("tests/architecture/" + name));
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.front() != '#') lines.push_back(line);
  }
  return lines;
}

/// Returns the words of the first column of docs/glossary.md.
Words GlossaryWords(const std::string& glossary) {
  Words words;
  std::istringstream in(glossary);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("| ")) continue;
    for (const PlacedWord& placed : WordsIn(line.substr(0, line.find('|', 2)))) {
      words.insert(placed.word);
    }
  }
  return words;
}

/// Returns the words refused: small words with what to write in their place, and whole names.
std::map<std::string, std::string> RefusedWords(const std::vector<std::string>& lines) {
  std::map<std::string, std::string> refused;
  for (const std::string& line : lines) {
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) refused[line.substr(0, colon)] = line.substr(colon + 2);
  }
  return refused;
}

/// Returns "path:line: word: what to write" for each refused word of a text, code and literals
/// included.
std::vector<std::string> RefusedIn(const std::string& path, const std::string& text,
                                   const std::map<std::string, std::string>& refused) {
  std::vector<std::string> found;
  const auto check = [&](const std::string& word, std::size_t line) {
    const auto it = refused.find(word);
    if (it == refused.end()) return;
    found.push_back(path + ":" + std::to_string(line) + ": " + word + ": " + it->second);
  };
  for (const PlacedWord& name : NamesIn(text)) {
    const std::vector<std::string> words = WordsOfName(name.word);
    for (const std::string& word : words) check(word, name.line);
    if (words.size() != 1 || words.front() != name.word) check(name.word, name.line);
  }
  return found;
}

bool IsHistory(const std::string& path) {
  return path.starts_with("docs/decisions/") || path.starts_with("docs/results/") ||
         path == "docs/changelog.md";
}

bool IsSource(const std::filesystem::path& file) {
  return file.extension() == ".h" || file.extension() == ".cpp" || file.extension() == ".idl";
}

TEST(Words, RefusedWordsDoNotOccur) {
  std::map<std::string, std::string> refused = RefusedWords(ListLines("refused_words.txt"));
  EXPECT_GE(refused.size(), 20U);
  for (const std::string& word : GlossaryWords(testing::TreeText("docs/glossary.md"))) {
    refused.erase(word);
  }
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    const std::string path = file.string();
    const bool is_own = path == "tests/architecture/words_test.cpp" ||
                        path == "tests/architecture/comments_test.cpp";
    if (is_own || IsHistory(path) || (file.extension() != ".md" && !IsSource(file))) continue;
    for (const std::string& found : RefusedIn(path, testing::TreeText(file), refused)) {
      ADD_FAILURE() << found;
    }
  }
}

TEST(Words, EachRefusedWordHasAReplacement) {
  const std::vector<std::string> lines = ListLines("refused_words.txt");
  EXPECT_EQ(RefusedWords(lines).size(), lines.size())
      << "a line has a word, a colon and what to write";
}

TEST(Words, DetectsRefusedWordsInNamesLiteralsAndProse) {
  const std::map<std::string, std::string> refused =
      RefusedWords({"sieve: pre-filter", "LookAt: Query"});
  EXPECT_THAT(
      RefusedIn("a.h", "int SieveOf();\nputs(\"a sieve\");\nLookAt(kSievedPoint, LookAtMe);",
                refused),
      ::testing::ElementsAre("a.h:1: sieve: pre-filter", "a.h:2: sieve: pre-filter",
                             "a.h:3: LookAt: Query"));
}

TEST(Words, NamesAreSplitAtCapitalsAndUnderscores) {
  EXPECT_THAT(WordsOfName("kWorstRTTOfPeer_dds"),
              ::testing::ElementsAre("worst", "rtt", "peer", "dds"));
  EXPECT_THAT(WordsOfName("X_WB"), ::testing::IsEmpty());
  EXPECT_THAT(WordsOfName("utf8"), ::testing::IsEmpty());
}

}  // namespace
}  // namespace tandem
