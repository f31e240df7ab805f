#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

namespace tandem {
namespace {

// A glob that checks itself runs CMake in every dry run of ninja, and ./tandem says "building" at
// every command. A glob that nothing checks misses new files. The folder's own time does neither.
TEST(BuildFiles, GlobsFollowTheirFoldersAndLeaveAnUpToDateBuildAlone) {
  std::vector<std::string> wrong;
  std::size_t globs = 0;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    if (file.filename() != "CMakeLists.txt") continue;  // other files build things apart
    const std::string text = testing::TreeText(file);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("file(GLOB")) continue;
      ++globs;
      if (line.find(" CONFIGURE_DEPENDS") != std::string::npos ||
          text.find("PROPERTY CMAKE_CONFIGURE_DEPENDS") == std::string::npos) {
        wrong.push_back(file.string() + ": " + line);
      }
    }
  }
  EXPECT_GE(globs, 1U);
  EXPECT_THAT(wrong, ::testing::IsEmpty());
}

}  // namespace
}  // namespace tandem
