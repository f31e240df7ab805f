#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

// Tests where injected faults are: in the patches of tests/simulator/faults, not in the product.
namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

bool IsProduct(const std::filesystem::path& file) {
  const std::string top = file.begin()->string();
  return top == "engine" || top == "collab" || top == "app";
}

/// Returns whether a source of the product names the injected faults of tests.
bool NamesFaults(const std::string& source) {
  constexpr std::array<std::string_view, 3> kWords{"Injected(", "injected_faults",
                                                   "injected_hand_faults"};
  return std::ranges::any_of(kWords, [&](std::string_view word) {
    return source.find(word) != std::string::npos;
  });
}

TEST(FaultPatches, TheProductHasNoInjectedFaults) {
  std::size_t read = 0;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    if (!IsProduct(file)) continue;
    ++read;
    EXPECT_FALSE(NamesFaults(testing::TreeText(file))) << file;
  }
  EXPECT_GT(read, 500U);
}

TEST(FaultPatches, DetectsFaultNames) {
  EXPECT_TRUE(NamesFaults("  if (Injected(Fault::kNone)) return;"));
  EXPECT_TRUE(NamesFaults("#include \"tests/simulator/injected_faults.h\""));
  EXPECT_TRUE(NamesFaults("#include \"tests/simulator/injected_hand_faults.h\""));
  EXPECT_FALSE(NamesFaults("double planted_slower = 1;  // injected"));
}

/// A patch of a file of this tree.
struct FaultPatch {
  std::string file;                // from the top of the tree
  std::vector<std::string> hunks;  // text that each hunk takes the place of
};

FaultPatch ReadPatch(const std::string& text) {
  FaultPatch patch;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("+++ ")) continue;
    if (line.starts_with("--- ")) {
      patch.file = line.substr(4);
    } else if (line.starts_with("@@")) {
      patch.hunks.emplace_back();
    } else if (!patch.hunks.empty() && !line.starts_with('+')) {
      patch.hunks.back() += line.substr(std::min<std::size_t>(1, line.size())) + '\n';
    }
  }
  return patch;
}

/// Returns how often `part` stands in a text, at the beginning of a line.
std::size_t TimesIn(const std::string& text, const std::string& part) {
  std::size_t times = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    if (at == 0 || text[at - 1] == '\n') ++times;
  }
  return times;
}

/// Returns the hunks of a patch that a text has no place for, or more than one.
std::vector<std::string> HunksWithoutOnePlace(const FaultPatch& patch, const std::string& text) {
  std::vector<std::string> wrong;
  for (const std::string& hunk : patch.hunks) {
    if (hunk.empty() || TimesIn(text, hunk) != 1) wrong.push_back(hunk);
  }
  return wrong;
}

TEST(FaultPatches, EachHunkMatchesOneLocation) {
  std::size_t patches = 0;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    if (file.extension() != ".patch") continue;
    ++patches;
    const FaultPatch patch = ReadPatch(testing::TreeText(file));
    EXPECT_EQ(file.parent_path(), "tests/simulator/faults");
    EXPECT_EQ(file.stem(), std::filesystem::path(patch.file).filename()) << file;
    EXPECT_FALSE(patch.hunks.empty()) << file;
    EXPECT_THAT(HunksWithoutOnePlace(patch, testing::TreeText(patch.file)), IsEmpty()) << file;
  }
  EXPECT_GT(patches, 10U);
}

TEST(FaultPatches, DetectsHunksWithoutOneLocation) {
  const FaultPatch patch = ReadPatch(
      "--- a/b.cpp\n"
      "+++ a/b.cpp\n"
      "@@ -1,2 +1,3 @@\n"
      " one\n"
      "+fault\n"
      " two\n"
      "@@ -4,2 +5,2 @@\n"
      " \n"
      "-three\n"
      "+fault\n");
  EXPECT_EQ(patch.file, "a/b.cpp");
  EXPECT_THAT(patch.hunks, ElementsAre("one\ntwo\n", "\nthree\n"));
  EXPECT_THAT(HunksWithoutOnePlace(patch, "one\ntwo\n\nthree\n"), IsEmpty());
  EXPECT_THAT(HunksWithoutOnePlace(patch, "one\ntwo\nthree\n"), ElementsAre("\nthree\n"));
  EXPECT_THAT(HunksWithoutOnePlace(patch, "one\ntwo\none\ntwo\n\nthree\n"),
              ElementsAre("one\ntwo\n"));
}

/// Returns the files whose patches a build file applies.
std::vector<std::string> FilesThatAreChanged(const std::string& build_file) {
  static const std::regex changed(R"(\n\s+((engine|collab|app)/[\w/]+\.(cpp|h))(?=\n))");
  std::vector<std::string> files;
  for (std::sregex_iterator it(build_file.begin(), build_file.end(), changed), end; it != end;
       ++it) {
    files.push_back((*it)[1]);
  }
  return files;
}

TEST(FaultPatches, EveryPatchIsBuilt) {
  std::vector<std::string> patched;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    if (file.extension() == ".patch") patched.push_back(ReadPatch(testing::TreeText(file)).file);
  }
  EXPECT_THAT(FilesThatAreChanged(testing::TreeText("tests/simulator/CMakeLists.txt")),
              ::testing::UnorderedElementsAreArray(patched));
}

}  // namespace
}  // namespace tandem
