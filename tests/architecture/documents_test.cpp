#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

// The paths of this tree that a text names in `code` or as a [link](target).
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
  std::vector<std::filesystem::path> documents = {top / "README.md"};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(top / "docs")) {
    if (entry.path().extension() == ".md") documents.push_back(entry.path());
  }
  std::vector<std::string> missing;
  std::size_t named = 0;
  for (const std::filesystem::path& document : documents) {
    std::ostringstream text;
    text << std::ifstream(document).rdbuf();
    for (const std::string& path : PathsNamedIn(text.str())) {
      ++named;
      if (!std::filesystem::exists(top / path)) {
        missing.push_back(document.filename().string() + " names " + path);
      }
    }
  }
  EXPECT_GT(named, 20U);
  EXPECT_THAT(missing, ::testing::IsEmpty());
}

/// What a text cites that a reader of this tree cannot find: documents that are not in it, whatever
/// their folder, decisions without a file, and notes, studies and issues that were never here.
std::vector<std::string> CitedInVain(const std::string& text, const std::set<std::string>& names,
                                     const std::set<std::string>& decisions) {
  static const std::regex document(R"(\b([\w-]+\.md)\b)");
  static const std::regex decision(R"((?:docs/decisions/|[Dd]ecisions?\s+|\s\()(0\d{3})\b)");
  static const std::regex elsewhere(
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
  matches(elsewhere, 0, [&](const std::string& words) {
    vain.push_back(words);
  });
  return vain;
}

TEST(Documents, WhatIsCitedIsInTheTree) {
  const std::filesystem::path top = TANDEM_SOURCE_DIR;
  std::set<std::string> names;
  std::set<std::string> decisions;
  std::vector<std::filesystem::path> files;
  for (auto it = std::filesystem::recursive_directory_iterator(top);
       it != std::filesystem::recursive_directory_iterator(); ++it) {
    const std::string name = it->path().filename();
    if (it->is_directory() && (name.starts_with("build") || name.starts_with('.'))) {
      it.disable_recursion_pending();
    }
    const std::string type = it->path().extension();
    if (type == ".md") names.insert(name);
    if (it->path().parent_path() == top / "docs/decisions") decisions.insert(name.substr(0, 4));
    const bool ours = type == ".h" || type == ".cpp" || type == ".md" || type == ".idl" ||
                      name == "CMakeLists.txt" || name == "tandem";
    // this test cites in vain to see that it is found
    if (ours && it->is_regular_file() && name != "documents_test.cpp") files.push_back(it->path());
  }
  EXPECT_GE(decisions.size(), 20U);
  std::vector<std::string> vain;
  for (const std::filesystem::path& file : files) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    for (const std::string& what : CitedInVain(text.str(), names, decisions)) {
      vain.push_back(std::filesystem::relative(file, top).string() + " cites " + what);
    }
  }
  EXPECT_THAT(vain, ::testing::IsEmpty());
}

TEST(Documents, WhatIsCitedInVainIsFound) {
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

TEST(Documents, PathsAreFoundInCodeAndInLinks) {
  EXPECT_THAT(PathsNamedIn("see `engine/base/a.h`, [notes](docs/b.md) and engine/plain"),
              ::testing::ElementsAre("engine/base/a.h", "docs/b.md"));
}

}  // namespace
}  // namespace tandem
