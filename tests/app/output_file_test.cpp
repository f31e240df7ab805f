#include "app/output_file.h"

#include <csignal>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

std::string ContentOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::size_t EntriesOf(const std::filesystem::path& folder) {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& one : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

TEST(WriteWhole, WritesAndReplacesAndLeavesNothingBeside) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.path() / "report";
  ASSERT_TRUE(WriteWhole(file, "one"));
  EXPECT_EQ(ContentOf(file), "one");
  ASSERT_TRUE(WriteWhole(file, std::string(1 << 20, 'x')));
  EXPECT_EQ(ContentOf(file), std::string(1 << 20, 'x'));
  EXPECT_EQ(EntriesOf(folder.path()), 1U);
}

TEST(WriteWhole, AFullDiskLeavesTheFileThatWasThere) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.path() / "report";
  ASSERT_TRUE(WriteWhole(file, "before"));
  // a file may not grow beyond this: what a disk without room does, in one process
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{.rlim_cur = 4096, .rlim_max = old.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const Result<bool> written = WriteWhole(file, std::string(1 << 20, 'x'));
  setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find("cannot be written"), std::string::npos);
  EXPECT_EQ(ContentOf(file), "before");
  EXPECT_EQ(EntriesOf(folder.path()), 1U);
}

TEST(WriteWhole, ALinkStaysALinkAndModesStay) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.path() / "report";
  const std::filesystem::path link = folder.path() / "link";
  ASSERT_TRUE(WriteWhole(file, "one"));
  ASSERT_EQ(chmod(file.c_str(), 0640), 0);
  std::filesystem::create_symlink(file, link);
  ASSERT_TRUE(WriteWhole(link, "two"));
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(ContentOf(file), "two");
  struct stat mode {};
  ASSERT_EQ(stat(file.c_str(), &mode), 0);
  EXPECT_EQ(mode.st_mode & 07777, 0640U);
}

TEST(WriteWhole, WhatIsNoRegularFileIsWrittenToStraight) {
  ASSERT_TRUE(WriteWhole("/dev/null", "gone"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_FALSE(WriteWhole("/dev/full", "no room"));
}

}  // namespace
}  // namespace tandem
