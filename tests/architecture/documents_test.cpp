#include <algorithm>
#include <cctype>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

namespace tandem {
namespace {

std::vector<std::filesystem::path> Documents() {
  std::vector<std::filesystem::path> documents = testing::TreeFiles();
  std::erase_if(documents, [](const std::filesystem::path& file) {
    return file.extension() != ".md";
  });
  return documents;
}

// Returns the paths of this tree that a text names in `code` or as a [link](target).
std::vector<std::string> PathsNamedIn(const std::string& text) {
  static const std::regex path(R"((`|\]\()((engine|collab|app|idl|tests|docs)/[\w./-]+)[`)])");
  std::vector<std::string> paths;
  for (std::sregex_iterator it(text.begin(), text.end(), path), end; it != end; ++it) {
    paths.push_back((*it)[2]);
  }
  return paths;
}

TEST(Documents, NameOnlyFilesThatExist) {
  const std::filesystem::path top = TANDEM_SOURCE_DIR;
  std::vector<std::string> missing;
  std::size_t named = 0;
  for (const std::filesystem::path& document : Documents()) {
    for (const std::string& path : PathsNamedIn(testing::TreeText(document))) {
      ++named;
      if (!std::filesystem::exists(top / path)) {
        missing.push_back(document.string() + " names " + path);
      }
    }
  }
  EXPECT_GT(named, 20U);
  EXPECT_THAT(missing, ::testing::IsEmpty());
}

// Returns a heading's anchor as web pages of repositories make it: small letters, digits, - and _.
std::string AnchorOf(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '-' || c == '_') {
      anchor += static_cast<char>(std::tolower(byte));
    } else if (c == ' ') {
      anchor += '-';
    }
  }
  return anchor;
}

std::set<std::string> AnchorsIn(const std::string& text) {
  static const std::regex heading(R"((?:^|\n)#+ ([^\n]*))");
  std::set<std::string> anchors;
  for (std::sregex_iterator it(text.begin(), text.end(), heading), end; it != end; ++it) {
    anchors.insert(AnchorOf((*it)[1]));
  }
  return anchors;
}

/// Returns the links of a document to files and headings of this tree that lead nowhere.
std::vector<std::string> BrokenLinks(const std::filesystem::path& document,
                                     const std::string& text) {
  static const std::regex link(R"(\]\(([^)\s#]*)(?:#([^)\s]*))?\))");
  const std::filesystem::path top = TANDEM_SOURCE_DIR;
  std::vector<std::string> broken;
  for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it) {
    const std::string target = (*it)[1];
    const std::string anchor = (*it)[2];
    if (target.find("://") != std::string::npos) continue;
    const std::filesystem::path file =
        target.empty() ? document : (document.parent_path() / target).lexically_normal();
    const bool there = std::filesystem::exists(top / file);
    const std::string& headings = target.empty() ? text : testing::TreeText(file);
    if (!there || (!anchor.empty() && !AnchorsIn(headings).contains(anchor))) {
      broken.push_back(document.string() + " links to " + (*it)[0].str().substr(2));
    }
  }
  return broken;
}

TEST(Documents, LinkOnlyToFilesAndHeadingsThatExist) {
  std::vector<std::string> broken;
  for (const std::filesystem::path& document : Documents()) {
    for (std::string& link : BrokenLinks(document, testing::TreeText(document))) {
      broken.push_back(std::move(link));
    }
  }
  EXPECT_THAT(broken, ::testing::IsEmpty());
}

TEST(Documents, BrokenLinksAreFound) {
  const std::string text =
      "# What is `here`?\n[a](#what-is-here) [b](#gone) [c](../README.md) [d](gone.png)\n"
      "[e](https://example.org/gone) [f](notation.md#gone) ![g](images/demo.png)";
  EXPECT_THAT(
      BrokenLinks("docs/design.md", text),
      ::testing::ElementsAre("docs/design.md links to #gone)", "docs/design.md links to gone.png)",
                             "docs/design.md links to notation.md#gone)"));
}

/// Returns the citations in a text that a reader of this repository cannot look up: documents that
/// are not in it, whatever their folder, decisions without a file, and private notes, numbered
/// studies, trackers' issues and sections of a paper that is named by initials alone.
std::vector<std::string> CitedInVain(const std::string& text, const std::set<std::string>& names,
                                     const std::set<std::string>& decisions) {
  static const std::regex document(R"(\b([\w-]+\.md)\b)");
  static const std::regex decision(R"((?:docs/decisions/|[Dd]ecisions?\s+|\s\()(0\d{3})\b)");
  static const std::regex not_published(
      R"(\bnotes:|\bnotes (?:of|on) |\b[Ss]tudy \d|\b(?:engine|sessions?|stability) issue\b|\bVPS §)");
  std::vector<std::string> vain;
  const auto matches = [&text](const std::regex& pattern, std::size_t group, const auto& use) {
    for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) {
      use((*it)[group].str());
    }
  };
  matches(document, 1, [&](const std::string& name) {
    if (!names.contains(name)) vain.push_back(name);
  });
  matches(decision, 1, [&](const std::string& number) {
    if (!decisions.contains(number)) vain.push_back("decision " + number);
  });
  matches(not_published, 0, [&](const std::string& words) {
    vain.push_back(words);
  });
  return vain;
}

TEST(Documents, CitationsAreInTheRepository) {
  std::set<std::string> names;
  std::set<std::string> decisions;
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    const std::string name = file.filename();
    const std::string type = file.extension();
    if (type == ".md") names.insert(name);
    if (file.parent_path() == "docs/decisions") decisions.insert(name.substr(0, 4));
    const bool ours = type == ".h" || type == ".cpp" || type == ".md" || type == ".idl" ||
                      name == "CMakeLists.txt" || name == "tandem";
    // this test cites in vain to see that it is found
    if (ours && name != "documents_test.cpp") files.push_back(file);
  }
  EXPECT_GE(decisions.size(), 20U);
  std::vector<std::string> vain;
  for (const std::filesystem::path& file : files) {
    for (const std::string& what : CitedInVain(testing::TreeText(file), names, decisions)) {
      vain.push_back(file.string() + " cites " + what);
    }
  }
  EXPECT_THAT(vain, ::testing::IsEmpty());
}

TEST(Documents, DetectsBrokenCitations) {
  const auto vain = [](const std::string& text) {
    return CitedInVain(text, {"here.md"}, {"0001", "0012"});
  };
  EXPECT_THAT(vain("docs/here.md, docs/decisions/0012-a.md (paper §4.1; 0001), a note of it"),
              ::testing::ElementsAre("0012-a.md"));
  EXPECT_THAT(vain("(GONE.md §4)"), ::testing::ElementsAre("GONE.md"));
  EXPECT_THAT(vain("as in decision 0099"), ::testing::ElementsAre("decision 0099"));
  EXPECT_THAT(vain("so (0098)"), ::testing::ElementsAre("decision 0098"));
  EXPECT_THAT(vain("(notes: so it is)"), ::testing::ElementsAre("notes:"));
  EXPECT_THAT(vain("notes on stability"), ::testing::ElementsAre("notes on "));
  EXPECT_THAT(vain("of study 7"), ::testing::ElementsAre("study 7"));
  EXPECT_THAT(vain("left to the sessions issue"), ::testing::ElementsAre("sessions issue"));
}

/// Returns what keeps a decision from being one page in the form of CONTRIBUTING.md: a title, a
/// line that begins with "Status: ", and four headings in their order.
std::vector<std::string> FaultsOfDecision(const std::string& text) {
  constexpr std::size_t kMostLines = 60;
  constexpr std::size_t kMostColumns = 140;
  const std::vector<std::string> parts{"# ",          "Status: ",        "## Context",
                                       "## Decision", "## Consequences", "## Alternatives"};
  std::vector<std::string> faults;
  std::vector<std::string> found;
  std::size_t lines = 0;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    ++lines;
    const bool is_table = line.starts_with("|");
    const auto columns = std::ranges::count_if(line, [](char c) {
      return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // bytes that begin a letter
    });
    if (!is_table && static_cast<std::size_t>(columns) > kMostColumns) {
      faults.push_back("line " + std::to_string(lines) + " has more than 140 columns");
    }
    const bool is_title = lines == 1 && line.starts_with(parts[0]);
    const bool is_status = line.starts_with(parts[1]);
    if (is_title || is_status) {
      found.push_back(parts[is_title ? 0 : 1]);
    } else if (line.starts_with("#")) {
      found.push_back(line);
    }
  }
  if (lines > kMostLines) {
    faults.push_back(std::to_string(lines) +
                     " lines: keep a page of 60, move figures to docs/results, or split it");
  }
  if (found != parts) {
    faults.emplace_back(
        "the form is a title, Status:, Context, Decision, Consequences, Alternatives");
  }
  return faults;
}

TEST(Documents, DecisionsAreOnePageInOneForm) {
  std::size_t decisions = 0;
  for (const std::filesystem::path& file : Documents()) {
    if (file.parent_path() != "docs/decisions" || file.filename() == "README.md") continue;
    ++decisions;
    for (const std::string& fault : FaultsOfDecision(testing::TreeText(file))) {
      ADD_FAILURE() << file.string() << ": " << fault;
    }
  }
  EXPECT_GE(decisions, 50U);
}

TEST(Documents, DecisionsInAnotherFormAreFound) {
  const std::string good =
      "# 0001: a\n\nStatus: accepted\n\n## Context\n\nb\n\n## Decision\n\nc\n\n"
      "## Consequences\n\nd\n\n## Alternatives\n\ne\n";
  const auto long_text = [&good](std::size_t more) {
    std::string text = good;
    for (std::size_t i = 0; i < more; ++i) text += "- f\n";
    return text;
  };
  EXPECT_THAT(FaultsOfDecision(good), ::testing::IsEmpty());
  EXPECT_THAT(FaultsOfDecision(long_text(41)), ::testing::IsEmpty());
  EXPECT_THAT(FaultsOfDecision(long_text(42)), ::testing::ElementsAre(::testing::HasSubstr("61 ")));
  EXPECT_THAT(FaultsOfDecision(good + "## Next\n"),
              ::testing::ElementsAre(::testing::HasSubstr("the form is")));
  EXPECT_THAT(FaultsOfDecision(good.substr(0, 9) + good.substr(29)),
              ::testing::ElementsAre(::testing::HasSubstr("the form is")));
  EXPECT_THAT(FaultsOfDecision(good + std::string(140, 'g') + "\n| " + std::string(200, 'h')),
              ::testing::IsEmpty());
  EXPECT_THAT(FaultsOfDecision(good + "\u00B5" + std::string(140, 'g')),
              ::testing::ElementsAre(::testing::HasSubstr("line 20 ")));
}

/// Returns the names that a text gives as `file.h`: `Name`, `Name` and that the file does not have.
std::vector<std::string> NamesMissingInFiles(const std::string& text) {
  static const std::regex place(R"(`([\w./-]+\.(?:h|cpp))`: ((?:`\w+`(?:, )?)+))");
  static const std::regex quoted(R"(`(\w+)`)");
  std::vector<std::string> missing;
  for (std::sregex_iterator it(text.begin(), text.end(), place), end; it != end; ++it) {
    const std::string file = (*it)[1];
    const std::string names = (*it)[2];
    const std::string& source = testing::TreeText(file);
    for (std::sregex_iterator name(names.begin(), names.end(), quoted); name != end; ++name) {
      const std::string word = (*name)[1];
      if (!std::regex_search(source, std::regex("\\b" + word + "\\b"))) {
        missing.push_back(file + ": " + word);
      }
    }
  }
  return missing;
}

TEST(Documents, PaperMapNamesOnlyFunctionsThatExist) {
  EXPECT_THAT(NamesMissingInFiles(testing::TreeText("docs/paper_map.md")), ::testing::IsEmpty());
}

TEST(Documents, DetectsUnknownFunctions) {
  EXPECT_THAT(NamesMissingInFiles("`engine/base/units.h`: `kMs`, `kGone`, and `kFar`"),
              ::testing::ElementsAre("engine/base/units.h: kGone"));
}

TEST(TreeFiles, IncludeNestedFoldersNamedBuild) {
  EXPECT_THAT(testing::TreeFiles(),
              ::testing::Contains(std::filesystem::path("engine/voxel/build/voxelize.h")));
}

TEST(Documents, DetectsPathsInCodeAndInLinks) {
  EXPECT_THAT(PathsNamedIn("see `engine/base/a.h`, [notes](docs/b.md) and engine/plain"),
              ::testing::ElementsAre("engine/base/a.h", "docs/b.md"));
}

}  // namespace
}  // namespace tandem
