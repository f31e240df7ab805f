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

#include "tests/architecture/source_comments.h"
#include "tests/architecture/tree_files.h"

// Tests that comments and documents have words which a stranger knows or can look up: plain English
// (vocabulary.txt), terms of the field (standard_terms.txt) and docs/glossary.md. Words of an
// earlier dialect of this project (refused_words.txt) occur neither there nor in names and texts to
// users.
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

/// Returns a text with spaces in place of what is no prose: `code`, fenced blocks, targets of links
/// and web addresses. Line breaks stay.
std::string Prose(std::string text) {
  const auto blank = [&text](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < std::min(to, text.size()); ++i) {
      if (text[i] != '\n') text[i] = ' ';
    }
  };
  const auto blank_between = [&](std::string_view open, std::string_view close, bool in_paragraph) {
    for (std::size_t at = text.find(open); at != std::string::npos; at = text.find(open, at + 1)) {
      const std::size_t end = text.find(close, at + open.size());
      if (end == std::string::npos) break;
      if (in_paragraph && text.find("\n\n", at) < end) continue;
      blank(at, end + close.size());
    }
  };
  blank_between("\n```", "\n```", false);
  blank_between("`", "`", true);
  blank_between("](", ")", true);
  for (std::size_t at = text.find("://"); at != std::string::npos; at = text.find("://", at + 1)) {
    std::size_t begin = at;
    while (begin > 0 && IsLetter(text[begin - 1])) --begin;
    blank(begin, text.find_first_of(" \n)>\"", at));
  }
  return text;
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

/// Returns the words of which a word may be a regular form: "stopped" of stop, "goes" of go.
std::vector<std::string> Stems(const std::string& word) {
  std::vector<std::string> stems;
  const auto add = [&stems](std::string stem) {
    if (stem.size() >= 3) stems.push_back(std::move(stem));
  };
  const auto without = [&word](std::size_t letters) {
    return word.substr(0, word.size() - letters);
  };
  if (word.ends_with("ies")) add(without(3) + "y");
  if (word.ends_with("es")) add(without(2));
  if (word.ends_with("s")) add(without(1));
  for (const std::string_view ending : {"ed", "ing", "er", "est", "ers", "ings"}) {
    if (!word.ends_with(ending) || word.size() < ending.size() + 3) continue;
    const std::string stem = without(ending.size());
    add(stem);
    add(stem + "e");
    if (stem.back() == stem[stem.size() - 2]) add(stem.substr(0, stem.size() - 1));
    if (stem.back() == 'i') add(stem.substr(0, stem.size() - 1) + "y");
  }
  if (word.ends_with("ly")) {
    add(without(2));
    add(without(1) + "e");
    if (word.ends_with("ily")) add(without(3) + "y");
    if (word.ends_with("ally")) add(without(4));
  }
  for (const std::string_view prefix : {"un", "re", "non"}) {
    if (word.starts_with(prefix) && word.size() >= prefix.size() + 4) {
      add(word.substr(prefix.size()));
    }
  }
  return stems;
}

bool IsKnown(const std::string& word, const Words& known) {
  if (known.contains(word)) return true;
  for (const std::string& stem : Stems(word)) {
    if (known.contains(stem)) return true;
    for (const std::string& shorter : Stems(stem)) {
      if (known.contains(shorter)) return true;
    }
  }
  return false;
}

Words AcceptedWords() {
  Words known = GlossaryWords(testing::TreeText("docs/glossary.md"));
  for (const std::string name : {"vocabulary.txt", "standard_terms.txt"}) {
    for (std::string& line : ListLines(name)) known.insert(std::move(line));
  }
  return known;
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

/// Returns "path:line: word" for each word that is not known, once for each word.
std::vector<std::string> UnknownWords(const std::string& path, const std::string& text,
                                      const Words& known, Words& reported) {
  std::vector<std::string> unknown;
  const auto scan = [&](const std::string& prose, std::size_t first_line) {
    for (const PlacedWord& placed : WordsIn(prose)) {
      if (IsKnown(placed.word, known) || !reported.insert(placed.word).second) continue;
      unknown.push_back(path + ":" + std::to_string(first_line + placed.line - 1) + ": " +
                        placed.word);
    }
  };
  if (path.ends_with(".md")) {
    scan(Prose(text), 1);
  } else {
    for (const testing::SourceComment& comment : testing::CommentsOf(text)) {
      scan(Prose(comment.text), comment.line);
    }
  }
  return unknown;
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

TEST(Words, AreEnglishStandardOrInTheGlossary) {
  const Words known = AcceptedWords();
  Words reported;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    // docs/paper_map.md quotes the paper, and logs of measurements have words of other programs
    const bool is_document = file.extension() == ".md" && file != "docs/paper_map.md" &&
                             !file.string().starts_with("docs/results/");
    if (!is_document && !IsSource(file)) continue;
    for (const std::string& unknown :
         UnknownWords(file.string(), testing::TreeText(file), known, reported)) {
      ADD_FAILURE() << unknown
                    << ": write a plain word, or add it to tests/architecture/vocabulary.txt "
                       "(English), standard_terms.txt (the field) or docs/glossary.md (ours)";
    }
  }
  EXPECT_GT(known.size(), 2000U);
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

TEST(Words, ListsAreSortedSmallAndDisjoint) {
  const std::vector<std::string> plain = ListLines("vocabulary.txt");
  const std::vector<std::string> terms = ListLines("standard_terms.txt");
  const std::vector<std::string> lines = ListLines("refused_words.txt");
  EXPECT_LT(plain.size(), 3000U);  // a reviewer can still read it
  EXPECT_LT(terms.size(), 600U);
  EXPECT_TRUE(std::ranges::is_sorted(plain));
  EXPECT_TRUE(std::ranges::is_sorted(terms));
  const std::map<std::string, std::string> refused = RefusedWords(lines);
  EXPECT_EQ(refused.size(), lines.size()) << "a line has a word, a colon and what to write";
  for (const std::vector<std::string>& list : {plain, terms}) {
    EXPECT_EQ(Words(list.begin(), list.end()).size(), list.size()) << "a word stands twice";
    for (const std::string& word : list) {
      EXPECT_FALSE(refused.contains(word)) << word << " is accepted and refused";
    }
  }
}

TEST(Words, UnknownWordsAreNamedWithTheirLine) {
  const Words known{"peer", "stop", "carry", "the", "body", "true"};
  Words reported;
  EXPECT_THAT(UnknownWords("a.cpp",
                           "// the peers stopped\nint zorp;  // carries the\n"
                           "          // blick_body untrue\n// kTrueBodyGrond 0xzz1\n",
                           known, reported),
              ::testing::ElementsAre("a.cpp:3: blick", "a.cpp:4: grond"));
  EXPECT_THAT(
      UnknownWords("README.md", "the `zorp` [peer](frob.png)\n\n```\nzorp\n```\nblick flurb\n",
                   known, reported),
      ::testing::ElementsAre("README.md:6: flurb"));
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
