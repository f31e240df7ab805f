#include "collab/dds/security/unfinished_folder.h"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

std::ptrdiff_t EntriesOf(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

// There are private keys in it.
TEST(UnfinishedFolder, RemovesRemaindersOfAKilledProgram) {
  const ScratchFolder scratch;
  const fs::path place = scratch.path() / "anna";
  const pid_t killed = fork();
  if (killed == 0) {
    const Result<UnfinishedFolder> made = UnfinishedFolder::Make(place);
    std::ofstream(made->path() / "member.key") << "secret" << std::flush;
    kill(getpid(), SIGKILL);
  }
  waitpid(killed, nullptr, 0);
  ASSERT_EQ(EntriesOf(scratch.path()), 1) << "the unfinished folder";
  Result<UnfinishedFolder> made = UnfinishedFolder::Make(place);
  ASSERT_TRUE(made) << made.error().what;
  EXPECT_EQ(EntriesOf(scratch.path()), 1);
  EXPECT_TRUE(fs::is_empty(made->path()));
  EXPECT_TRUE(made->Commit());
  EXPECT_EQ(EntriesOf(scratch.path()), 1);
  EXPECT_TRUE(fs::is_directory(place));
}

TEST(UnfinishedFolder, LeavesAFolderInUse) {
  const ScratchFolder scratch;
  const fs::path place = scratch.path() / "anna";
  const Result<UnfinishedFolder> one = UnfinishedFolder::Make(place);
  ASSERT_TRUE(one) << one.error().what;
  const Result<UnfinishedFolder> other = UnfinishedFolder::Make(place);
  ASSERT_TRUE(other) << other.error().what;
  EXPECT_NE(one->path(), other->path());
  EXPECT_TRUE(fs::is_directory(one->path()));
  EXPECT_TRUE(fs::is_directory(other->path()));
}

}  // namespace
}  // namespace tandem
