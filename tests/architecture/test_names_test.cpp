#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

// Names of tests in documents and in the commands of docs/results.
namespace tandem {
namespace {

/// Returns the names of all tests of this tree, as Suite.Name.
std::set<std::string> TestNames() {
  static const std::regex test(R"(\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\s*\))");
  std::set<std::string> names;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    if (file.extension() != ".cpp" || *file.begin() != "tests") continue;
    const std::string& text = testing::TreeText(file);
    for (std::sregex_iterator it(text.begin(), text.end(), test), end; it != end; ++it) {
      names.insert((*it)[1].str() + "." + (*it)[2].str());
    }
  }
  return names;
}

/// Returns the tests that a text names as `Suite.Name`, or as a last field of csv, and that are not
/// among `tests`.
std::vector<std::string> TestsNamedInVain(const std::string& text,
                                          const std::set<std::string>& tests) {
  static const std::regex name(R"([`,]([A-Z]\w+\.[A-Z]\w+)(?=[`\n]))");
  std::vector<std::string> vain;
  for (std::sregex_iterator it(text.begin(), text.end(), name), end; it != end; ++it) {
    if (!tests.contains((*it)[1])) vain.push_back((*it)[1]);
  }
  return vain;
}

/// Returns whether a name is one that a pattern of --gtest_filter stands for.
bool IsMatch(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] == '*') {
    return IsMatch(pattern.substr(1), name) || (!name.empty() && IsMatch(pattern, name.substr(1)));
  }
  return !name.empty() && (pattern[0] == '?' || pattern[0] == name[0]) &&
         IsMatch(pattern.substr(1), name.substr(1));
}

/// Returns the patterns of the filters in a text that stand for none of `tests`. A test with
/// parameters runs as Instance/Suite.Name/parameter.
std::vector<std::string> PatternsWithoutATest(const std::string& text,
                                              const std::set<std::string>& tests) {
  static const std::regex filter(R"(--gtest_filter=["']?([\w.*?:/-]+))");
  std::vector<std::string> vain;
  for (std::sregex_iterator it(text.begin(), text.end(), filter), end; it != end; ++it) {
    std::string selected = (*it)[1];
    std::ranges::replace(selected, '-', ':');  // negative patterns follow a dash
    std::istringstream patterns(selected);
    for (std::string pattern; std::getline(patterns, pattern, ':');) {
      const auto is_match = [&pattern](const std::string& test) {
        return IsMatch(pattern, test) || IsMatch(pattern, "Instance/" + test + "/0");
      };
      if (!pattern.empty() && std::ranges::none_of(tests, is_match)) vain.push_back(pattern);
    }
  }
  return vain;
}

TEST(TestNames, DocumentsAndCommandsNameOnlyTestsThatExist) {
  const std::set<std::string> tests = TestNames();
  EXPECT_GT(tests.size(), 1000U);
  std::size_t texts = 0;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    const bool is_result = file.parent_path() == "docs/results" && file.extension() == ".csv";
    if (file.extension() != ".md" && !is_result) continue;
    ++texts;
    SCOPED_TRACE(file.string());
    const std::string& text = testing::TreeText(file);
    EXPECT_THAT(TestsNamedInVain(text, tests), ::testing::IsEmpty());
    EXPECT_THAT(PatternsWithoutATest(text, tests), ::testing::IsEmpty());
  }
  EXPECT_GT(texts, 100U);
}

TEST(TestNames, DetectsUnknownTests) {
  EXPECT_THAT(TestsNamedInVain("`Map.Is`, `Map.Was`, `README.md`, Map.Out", {"Map.Is"}),
              ::testing::ElementsAre("Map.Was"));
  EXPECT_THAT(TestsNamedInVain("1,mm,,any,Map.Is\n2,mm,,any,Map.Gone\n", {"Map.Is"}),
              ::testing::ElementsAre("Map.Gone"));
}

TEST(TestNames, DetectsFiltersWithoutATest) {
  const std::set<std::string> tests = {"Map.Is", "Maps.Are"};
  EXPECT_THAT(PatternsWithoutATest("`map_test --gtest_filter='Map*:*A?e'` --gtest_filter=*/*.Is/*\n"
                                   "map_test --gtest_filter=Map.* --gtest_output=xml:FILE",
                                   tests),
              ::testing::IsEmpty());
  EXPECT_THAT(PatternsWithoutATest("--gtest_filter='Map.*:Gone*' --gtest_filter=*-Map.Was", tests),
              ::testing::ElementsAre("Gone*", "Map.Was"));
  EXPECT_THAT(PatternsWithoutATest("--gtest_filter=Map.I", tests), ::testing::ElementsAre("Map.I"));
}

}  // namespace
}  // namespace tandem
