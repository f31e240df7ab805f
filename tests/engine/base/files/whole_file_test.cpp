#include "engine/base/files/whole_file.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string TextOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::ptrdiff_t FilesIn(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

/// Fills the disk after so many bytes of a file, for this process.
class FullAfter {
 public:
  explicit FullAfter(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FullAfter() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(WholeFile, AppearsOnlyWhenComplete) {
  const ScratchFolder scratch;
  const fs::path file = scratch.Write("out", "before");
  {
    WholeFile out = *WholeFile::Create(file);
    EXPECT_TRUE(out.Write(std::string(300'000, 'x')));
    EXPECT_EQ(TextOf(file), "before");
    EXPECT_FALSE(out.Commit().has_value());
  }
  EXPECT_EQ(TextOf(file), std::string(300'000, 'x'));
  EXPECT_EQ(FilesIn(scratch.path()), 1);
}

TEST(WholeFile, FullDiskKeepsTheOldFile) {
  const ScratchFolder scratch;
  const fs::path file = scratch.Write("out", "before");
  const FullAfter full(100'000);
  const auto failed = WriteWholeFile(file, std::string(300'000, 'x'));
  ASSERT_TRUE(failed.has_value());
  EXPECT_THAT(failed->what, HasSubstr(file.string() + ": cannot be written: File too large"));
  EXPECT_EQ(TextOf(file), "before");
  EXPECT_EQ(FilesIn(scratch.path()), 1);
}

TEST(WholeFile, AbandonedFileLeavesNothing) {
  const ScratchFolder scratch;
  { static_cast<void>(WholeFile::Create(scratch.path() / "out")->Write("half")); }
  EXPECT_EQ(FilesIn(scratch.path()), 0);
}

/// Returns a process that has ended, and whose number is free.
pid_t GoneProcess() {
  const pid_t pid = fork();
  if (pid == 0) _exit(0);
  waitpid(pid, nullptr, 0);
  return pid;
}

TEST(WholeFile, RemovesRemaindersOfAKilledProgram) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "out";
  const pid_t killed = fork();
  if (killed == 0) {
    WholeFile out = *WholeFile::Create(file);
    out.Write(std::string(100'000, 'x'));
    kill(getpid(), SIGKILL);
  }
  waitpid(killed, nullptr, 0);
  ASSERT_EQ(FilesIn(scratch.path()), 1) << "the unfinished file";
  EXPECT_FALSE(WriteWholeFile(scratch.path() / "other", "x").has_value());
  EXPECT_EQ(FilesIn(scratch.path()), 2) << "it is not of that file";
  EXPECT_FALSE(WriteWholeFile(file, "whole").has_value());
  EXPECT_EQ(FilesIn(scratch.path()), 2);
  EXPECT_EQ(TextOf(file), "whole");
}

TEST(WholeFile, CleanupSparesFilesInUseAndForeignFiles) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "out";
  WholeFile here = *WholeFile::Create(file);
  here.Write("here");
  const std::string gone = std::to_string(GoneProcess());
  // a file of a process that is there, but holds no lock
  scratch.Write("out.unfinished-" + std::to_string(getppid()) + "-0", "x");
  // others' files, by their names
  for (const std::string& words : {gone + "-0.txt", gone + "-", "-" + gone, gone + "x"}) {
    scratch.Write("out.unfinished-" + words, "x");
  }
  fs::create_symlink(file, scratch.path() / ("out.unfinished-" + gone + "-1"));
  ASSERT_EQ(FilesIn(scratch.path()), 7);
  EXPECT_FALSE(WriteWholeFile(file, "whole").has_value());
  EXPECT_EQ(FilesIn(scratch.path()), 8);
  EXPECT_FALSE(here.Commit().has_value());
  EXPECT_EQ(TextOf(file), "here");
  EXPECT_EQ(FilesIn(scratch.path()), 7);
}

TEST(WholeFile, WritesThroughSymbolicLinksAndIntoDevices) {
  const ScratchFolder scratch;
  const fs::path file = scratch.Write("out", "before");
  fs::create_symlink(file, scratch.path() / "link");
  EXPECT_FALSE(WriteWholeFile(scratch.path() / "link", "after").has_value());
  EXPECT_EQ(TextOf(file), "after");
  EXPECT_TRUE(fs::is_symlink(scratch.path() / "link"));
  EXPECT_FALSE(WriteWholeFile("/dev/null", "nothing").has_value());
  EXPECT_THAT(WriteWholeFile("/dev/full", "nothing")->what, HasSubstr("No space left on device"));
  EXPECT_THAT(WriteWholeFile(scratch.path(), "x")->what, HasSubstr("Is a directory"));
  EXPECT_THAT(WriteWholeFile("/nowhere/out", "x")->what, HasSubstr("No such file"));
}

TEST(WholeFile, KeepsThePermissionsOfTheReplacedFile) {
  const ScratchFolder scratch;
  const fs::path file = scratch.Write("out", "before");
  chmod(file.c_str(), 0600);
  EXPECT_FALSE(WriteWholeFile(file, "after").has_value());
  struct stat status {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

}  // namespace
}  // namespace tandem
