#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

// Tests the hook that CONTRIBUTING.md says how to enable.
namespace tandem {
namespace {

bool IsTaken(const std::string& message) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("tandem-message-" + std::to_string(getpid()));
  std::ofstream(file) << message;
  const std::string command =
      "sh " TANDEM_SOURCE_DIR "/.githooks/commit-msg " + file.string() + " 2>/dev/null";
  const bool taken = std::system(command.c_str()) == 0;
  std::filesystem::remove(file);
  return taken;
}

TEST(CommitHook, AcceptsSubjectsUpToSeventyTwoCharacters) {
  const std::string subject = "contact: " + std::string(63, 'a');
  ASSERT_EQ(subject.size(), 72U);
  EXPECT_TRUE(IsTaken(subject + "\n\nA body of any length, " + std::string(200, 'b') + "\n"));
  EXPECT_FALSE(IsTaken(subject + "a\n"));
}

TEST(CommitHook, CountsCharactersAndNotBytes) {
  std::string subject = "docs: ";
  for (int i = 0; i < 66; ++i) subject += "\u00e4";
  EXPECT_TRUE(IsTaken(subject + "\n"));
  EXPECT_FALSE(IsTaken(subject + "\u00e4\n"));
}

TEST(CommitHook, RequiresTheAreaAtTheBeginning) {
  EXPECT_FALSE(IsTaken("mend the thing\n"));
  EXPECT_FALSE(IsTaken(": mend the thing\n"));
  EXPECT_TRUE(IsTaken("# a comment of git's\nview: mend the thing\n"));
  EXPECT_TRUE(IsTaken("Merge branch 'main'\n"));
}

}  // namespace
}  // namespace tandem
