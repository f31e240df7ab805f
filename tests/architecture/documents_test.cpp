#include <filesystem>
#include <fstream>
#include <regex>
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

TEST(Documents, PathsAreFoundInCodeAndInLinks) {
  EXPECT_THAT(PathsNamedIn("see `engine/base/a.h`, [notes](docs/b.md) and engine/plain"),
              ::testing::ElementsAre("engine/base/a.h", "docs/b.md"));
}

}  // namespace
}  // namespace tandem
