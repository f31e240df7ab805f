#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

namespace tandem {
namespace {

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::optional<std::string> FirstMatch(const std::string& text, const std::regex& pattern) {
  std::smatch match;
  if (!std::regex_search(text, match, pattern)) return std::nullopt;
  return match[1];
}

std::string ProjectVersion() {
  static const std::regex version(R"(project\(tandem VERSION ([\d.]+))");
  return FirstMatch(testing::TreeText("CMakeLists.txt"), version).value_or("");
}

/// Returns the keys of a CFF file's first level with their values, without quotes. A key whose
/// value is a list or a text of several lines has the value "".
std::map<std::string, std::string> CitationFields(const std::string& text) {
  static const std::regex field(R"re(([a-z-]+):\s*"?([^"]*?)"?)re");
  std::map<std::string, std::string> fields;
  for (const std::string& line : LinesOf(text)) {
    std::smatch match;
    if (std::regex_match(line, match, field)) fields[match[1]] = match[2];
  }
  return fields;
}

/// Returns the faults in a changelog's form. It has "## Unreleased" first, then versions with their
/// date, the newest first. Each has the headings of Keep a Changelog, each once, and entries below
/// a heading.
std::vector<std::string> ChangelogFaults(const std::string& text) {
  static const std::regex release(R"(## (\d+)\.(\d+)\.(\d+) - \d{4}-\d{2}-\d{2})");
  static const std::set<std::string> kinds = {"### Added",   "### Changed", "### Deprecated",
                                              "### Removed", "### Fixed",   "### Security"};
  std::vector<std::string> faults;
  std::vector<std::array<int, 3>> versions;
  std::set<std::string> seen;
  bool unreleased = false;
  bool under_kind = false;
  for (const std::string& line : LinesOf(text)) {
    std::smatch match;
    if (line.starts_with("## ")) {
      seen.clear();
      under_kind = false;
      if (line == "## Unreleased" && !unreleased && versions.empty()) {
        unreleased = true;
      } else if (unreleased && std::regex_match(line, match, release)) {
        versions.push_back({std::stoi(match[1]), std::stoi(match[2]), std::stoi(match[3])});
      } else {
        faults.push_back(line);
      }
    } else if (line.starts_with("### ")) {
      under_kind = kinds.contains(line) && seen.insert(line).second;
      if (!under_kind) faults.push_back(line);
    } else if (line.starts_with("- ") && !under_kind) {
      faults.push_back(line);
    }
  }
  if (versions.empty()) faults.emplace_back("no version");
  if (!std::is_sorted(versions.rbegin(), versions.rend())) faults.emplace_back("order of versions");
  return faults;
}

/// Returns the packages that ./tandem installs.
std::vector<std::string> PackagesOf(const std::string& script) {
  static const std::regex list(R"(\npackages=\(\n([^)]*)\n\))");
  std::vector<std::string> packages;
  for (const std::string& line : LinesOf(FirstMatch(script, list).value_or(""))) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) packages.push_back(word);
  }
  return packages;
}

/// Returns the words that do not stand in a text by themselves.
std::vector<std::string> NotNamed(const std::vector<std::string>& words, const std::string& text) {
  std::vector<std::string> missing;
  for (const std::string& word : words) {
    const std::regex alone("(^|[^\\w-])" + word + "($|[^\\w-])");
    if (!std::regex_search(text, alone)) missing.push_back(word);
  }
  return missing;
}

TEST(FrontDoor, LicenceIsApache2) {
  const std::vector<std::string> lines = LinesOf(testing::TreeText("LICENSE"));
  ASSERT_GT(lines.size(), 200U);
  EXPECT_THAT(lines[1], ::testing::HasSubstr("Apache License"));
  EXPECT_THAT(lines[2], ::testing::HasSubstr("Version 2.0, January 2004"));
}

TEST(FrontDoor, CitationHasTheFieldsOfItsFormatAndTheProjectsVersion) {
  const std::string text = testing::TreeText("CITATION.cff");
  std::map<std::string, std::string> fields = CitationFields(text);
  ASSERT_THAT(fields,
              ::testing::IsSupersetOf({::testing::Key("message"), ::testing::Key("title"),
                                       ::testing::Key("authors"), ::testing::Key("references"),
                                       ::testing::Key("date-released")}));
  EXPECT_EQ(fields["cff-version"], "1.2.0");
  EXPECT_EQ(fields["license"], "Apache-2.0");
  ASSERT_FALSE(ProjectVersion().empty());
  EXPECT_EQ(fields["version"], ProjectVersion());
  EXPECT_THAT(
      testing::TreeText("docs/changelog.md"),
      ::testing::HasSubstr("\n## " + fields["version"] + " - " + fields["date-released"] + "\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("Voxel-Based 6-DOF Haptic Rendering Improvements"));
}

TEST(FrontDoor, CitationFieldsAreThoseOfTheFirstLevel) {
  EXPECT_THAT(CitationFields("version: 1.2\nauthors:\n  - name: \"A\"\ntitle: \"B: c\"\n"),
              ::testing::UnorderedElementsAre(::testing::Pair("version", "1.2"),
                                              ::testing::Pair("authors", ""),
                                              ::testing::Pair("title", "B: c")));
}

TEST(FrontDoor, ChangelogIsWellFormed) {
  const std::string changelog = testing::TreeText("docs/changelog.md");
  EXPECT_THAT(ChangelogFaults(changelog), ::testing::IsEmpty());
}

TEST(FrontDoor, DetectsMalformedChangelogs) {
  const std::string good =
      "# C\n\n## Unreleased\n\n### Added\n\n- a\n\n## 0.10.0 - 2026-02-01\n\n### Fixed\n\n- b\n\n"
      "## 0.9.1 - 2026-01-01\n\n### Changed\n\n- c\n  over two lines\n";
  EXPECT_THAT(ChangelogFaults(good), ::testing::IsEmpty());
  const auto faults = [](std::string text, const std::string& from, const std::string& to) {
    return ChangelogFaults(text.replace(text.find(from), from.size(), to));
  };
  EXPECT_THAT(faults(good, "### Fixed", "### Mended"), ::testing::ElementsAre("### Mended", "- b"));
  EXPECT_THAT(faults(good, "### Added\n", "- d\n### Added\n"), ::testing::ElementsAre("- d"));
  EXPECT_THAT(faults(good, "- a\n", "- a\n### Added\n"), ::testing::ElementsAre("### Added"));
  EXPECT_THAT(faults(good, " - 2026-02-01", ""), ::testing::ElementsAre("## 0.10.0"));
  EXPECT_THAT(faults(good, "0.9.1", "0.11.0"), ::testing::ElementsAre("order of versions"));
  EXPECT_THAT(ChangelogFaults("# C\n\n## Unreleased\n"), ::testing::ElementsAre("no version"));
}

// The page that everybody reads is short. The rest has its place behind links.
TEST(FrontDoor, ReadmeIsShort) {
  const std::string readme = testing::TreeText("README.md");
  EXPECT_LE(LinesOf(readme).size(), 130U);
  EXPECT_LE(readme.size(), 8000U);
  EXPECT_THAT(NotNamed({"docs/using.md", "docs/scene-format.md", "docs/stability.md",
                        "docs/benchmarks.md", "docs/architecture.md", "CONTRIBUTING.md",
                        "SECURITY.md", "LICENSE", "NOTICE", "CITATION.cff"},
                       readme),
              ::testing::IsEmpty());
}

TEST(FrontDoor, EveryPackageHasItsReasonAndItsLicence) {
  const std::vector<std::string> packages = PackagesOf(testing::TreeText("tandem"));
  ASSERT_GE(packages.size(), 10U);
  EXPECT_THAT(NotNamed(packages, testing::TreeText("docs/decisions/0001-dependencies.md")),
              ::testing::IsEmpty());
  std::vector<std::string> used = packages;
  const std::set<std::string> tools = {"build-essential", "ccache", "cmake", "ninja-build"};
  std::erase_if(used, [&tools](const std::string& package) {
    return tools.contains(package);
  });
  EXPECT_THAT(NotNamed(used, testing::TreeText("NOTICE")), ::testing::IsEmpty());
}

TEST(FrontDoor, PackagesAreReadFromTheScript) {
  EXPECT_THAT(PackagesOf("#!x\npackages=(\n  a b-dev   # c, d\n  e1\n)\nother=(\n f\n)\n"),
              ::testing::ElementsAre("a", "b-dev", "e1"));
  EXPECT_THAT(NotNamed({"a", "b-dev", "b", "c"}, "a (b-dev), c-dev"),
              ::testing::ElementsAre("b", "c"));
}

TEST(FrontDoor, EveryDecisionHasOneRowInTheIndex) {
  const std::string index = testing::TreeText("docs/decisions/README.md");
  std::vector<std::string> wrong;
  std::set<std::string> numbers;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    const std::string name = file.filename();
    if (file.parent_path() != "docs/decisions" || name == "README.md") continue;
    const std::string number = name.substr(0, 4);
    std::string row = "| [";
    row += number + "](" + name + ") | ";
    const std::size_t place = index.find(row);
    if (!numbers.insert(number).second || place == std::string::npos ||
        index.find("](" + name, place + row.size()) != std::string::npos) {
      wrong.push_back(name);
    }
  }
  EXPECT_GE(numbers.size(), 30U);
  EXPECT_THAT(wrong, ::testing::IsEmpty());
}

TEST(FrontDoor, ArchitectureNamesEveryFolderWithSources) {
  std::vector<std::string> folders;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    const std::string type = file.extension();
    if (type != ".cpp" && type != ".h" && type != ".idl") continue;
    if (*file.begin() == "docs") continue;  // examples, which are documents
    // the folders of the first two levels: app/view/model is part of app/view
    auto part = file.begin();
    std::filesystem::path folder = *part++;
    if (part != file.end() && std::next(part) != file.end()) folder /= *part;
    if (folders.empty() || folders.back() != folder) folders.push_back(folder);
  }
  ASSERT_GE(folders.size(), 20U);
  const std::string architecture = testing::TreeText("docs/architecture.md");
  std::erase_if(folders, [&architecture](const std::string& folder) {
    return architecture.find("`" + folder + "`") != std::string::npos;
  });
  EXPECT_THAT(folders, ::testing::IsEmpty());
}

// Nobody but a build file sets a variable that it sets for its tests.
TEST(FrontDoor, ContributingNamesEveryVariableThatTestsRead) {
  static const std::regex read(R"re(getenv\("(TANDEM_\w+)"\))re");
  std::set<std::string> variables;
  std::string build_files;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    if (*file.begin() != "tests") continue;
    const std::string text = testing::TreeText(file);
    if (file.filename() == "CMakeLists.txt") build_files += text;
    if (file.extension() != ".cpp") continue;
    for (std::sregex_iterator it(text.begin(), text.end(), read), end; it != end; ++it) {
      variables.insert((*it)[1]);
    }
  }
  std::erase_if(variables, [&build_files](const std::string& variable) {
    return build_files.find("ENVIRONMENT " + variable + "=") != std::string::npos;
  });
  ASSERT_GE(variables.size(), 5U);
  EXPECT_THAT(NotNamed({variables.begin(), variables.end()}, testing::TreeText("CONTRIBUTING.md")),
              ::testing::IsEmpty());
}

}  // namespace
}  // namespace tandem
