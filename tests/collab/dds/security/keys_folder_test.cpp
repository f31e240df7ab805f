#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "collab/dds/security/keys.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::ptrdiff_t FilesIn(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

unsigned ModeOf(const fs::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_mode & 0777U : 0;
}

/// Limits files to so many bytes, for this process and those that it starts.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~SmallFiles() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(KeysFolder, IsCompleteAndPrivate) {
  const ScratchFolder scratch;
  const fs::path session = scratch.path() / "new" / "keys";
  ASSERT_TRUE(MakeSessionKeys(session));
  ASSERT_TRUE(MakeMemberKeys(session, "anna", Role::kActive, session / "anna"));
  EXPECT_EQ(ModeOf(session), 0700U);
  EXPECT_EQ(ModeOf(session / "anna"), 0700U);
  EXPECT_EQ(ModeOf(session / "anna" / "identity.key"), 0600U);
  EXPECT_EQ(FilesIn(scratch.path() / "new"), 1);
  EXPECT_TRUE(LoadMemberKeys(session / "anna"));
}

// A full disk must not leave keys of no bytes, in a folder that is refused from then on.
TEST(KeysFolder, LeavesNothingOnAFullDisk) {
  const ScratchFolder scratch;
  const fs::path session = scratch.path() / "keys";
  for (const rlim_t bytes : {0U, 100U, 300U, 700U}) {
    const SmallFiles small(bytes);
    EXPECT_FALSE(MakeSessionKeys(session)) << bytes;
    EXPECT_EQ(FilesIn(scratch.path()), 0) << bytes;
  }
  ASSERT_TRUE(MakeSessionKeys(session));
  const std::ptrdiff_t files = FilesIn(session);
  for (const rlim_t bytes : {0U, 100U, 300U, 700U, 1500U}) {
    const SmallFiles small(bytes);
    EXPECT_FALSE(MakeMemberKeys(session, "anna", Role::kActive, session / "anna")) << bytes;
    EXPECT_EQ(FilesIn(session), files) << bytes;
  }
  EXPECT_TRUE(MakeMemberKeys(session, "anna", Role::kActive, session / "anna"));
}

TEST(KeysFolder, DoesNotOverwriteFiles) {
  const ScratchFolder scratch;
  fs::create_directories(scratch.path() / "empty");
  EXPECT_TRUE(MakeSessionKeys(scratch.path() / "empty"));
  const Result<bool> again = MakeSessionKeys(scratch.path() / "empty");
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().what, HasSubstr("exists already: keys are never overwritten"));
}

// Somebody who may set a variable of the caller's would choose who signs, and with what.
TEST(KeysFolder, UsesTheSystemsOpensslInAnyEnvironment) {
  const ScratchFolder scratch;
  const fs::path fake =
      scratch.Write("openssl", "#!/bin/sh\ntouch " + (scratch.path() / "called").string() + "\n");
  chmod(fake.c_str(), 0755);
  const std::string path = std::getenv("PATH") == nullptr ? "" : std::getenv("PATH");
  setenv("PATH", (scratch.path().string() + ":" + path).c_str(), 1);
  setenv("OPENSSL_CONF", scratch.Write("bad.cnf", "openssl_conf = none\n[").c_str(), 1);
  const Result<bool> made = MakeSessionKeys(scratch.path() / "keys");
  setenv("PATH", path.c_str(), 1);
  unsetenv("OPENSSL_CONF");
  EXPECT_TRUE(made) << made.error().what;
  EXPECT_FALSE(fs::exists(scratch.path() / "called"));
}

}  // namespace
}  // namespace tandem
