#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

namespace fs = std::filesystem;

// The CMakeLists.txt of this tree, what is built apart.
std::vector<fs::path> BuildFiles() {
  std::vector<fs::path> files;
  for (auto it = fs::recursive_directory_iterator(TANDEM_SOURCE_DIR);
       it != fs::recursive_directory_iterator(); ++it) {
    const std::string name = it->path().filename();
    if (it->is_directory() && (name.starts_with("build") || name.starts_with('.'))) {
      it.disable_recursion_pending();
    }
    if (name == "CMakeLists.txt") files.push_back(it->path());
  }
  return files;
}

std::string TextOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// A glob that checks itself runs CMake in every dry run of ninja, and ./tandem says "building" at
// every command; one that nothing checks misses new files. The folder's own time does neither.
TEST(BuildFiles, GlobsAreNoticedByTheirFoldersAndLeaveNinjaWithoutWork) {
  std::vector<std::string> wrong;
  std::size_t globs = 0;
  for (const fs::path& file : BuildFiles()) {
    const std::string text = TextOf(file);
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
