#include "engine/geometry/import/import_confinement.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/engine/geometry/import/mesh_file_samples.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

/// Returns whether `attempt` succeeds in a process that is confined to `file`.
bool Succeeds(const fs::path& file, const std::function<bool()>& attempt) {
  const pid_t child = fork();
  if (child == 0) {
    ConfineToFile(file);
    _exit(attempt() ? 0 : 1);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool Opens(const fs::path& file, int flags) {
  return open(file.c_str(), flags | O_CLOEXEC, 0600) >= 0;
}

class ImportConfinement : public ::testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers need what is taken away";
#endif
    fs::create_directory(inside_.path() / "textures");
    file_ = inside_.Write("part.obj", "v 0 0 0\n");
    secret_ = elsewhere_.Write("secret", "42");
  }
  testing::TempFolder inside_;
  testing::TempFolder elsewhere_;
  fs::path file_;
  fs::path secret_;
};

TEST_F(ImportConfinement, AllowsTheFileAndItsNeighbours) {
  inside_.Write("part.mtl", "newmtl a\n");
  inside_.Write("textures/a.bin", "x");
  EXPECT_TRUE(Succeeds(file_, [&] {
    return Opens(file_, O_RDONLY);
  }));
  EXPECT_TRUE(Succeeds(file_, [&] {
    return Opens(inside_.path() / "part.mtl", O_RDONLY);
  }));
  EXPECT_TRUE(Succeeds(file_, [&] {
    return Opens(inside_.path() / "textures/a.bin", O_RDONLY);
  }));
  // a link to a mesh is read, too
  fs::create_symlink(secret_, inside_.path() / "link.obj");
  EXPECT_TRUE(Succeeds(inside_.path() / "link.obj", [&] {
    return Opens(inside_.path() / "link.obj", O_RDONLY);
  }));
  EXPECT_TRUE(Succeeds(file_, [] {
    return malloc(100 << 20) != nullptr;
  }));
}

TEST_F(ImportConfinement, ForbidsOtherFilesAndWriting) {
  EXPECT_FALSE(Succeeds(file_, [&] {
    return Opens(secret_, O_RDONLY);
  }));
  EXPECT_FALSE(Succeeds(file_, [] {
    return Opens("/etc/passwd", O_RDONLY);
  }));
  EXPECT_FALSE(Succeeds(file_, [&] {
    return Opens(file_, O_WRONLY);
  }));
  EXPECT_FALSE(Succeeds(file_, [&] {
    return Opens(file_, O_RDWR);
  }));
  EXPECT_FALSE(Succeeds(file_, [&] {
    return Opens(inside_.path() / "new", O_CREAT | O_WRONLY);
  }));
  EXPECT_FALSE(Succeeds(file_, [&] {
    return unlink(file_.c_str()) == 0;
  }));
  EXPECT_FALSE(Succeeds(file_, [&] {
    return rename(file_.c_str(), "/tmp/x") == 0;
  }));
  EXPECT_TRUE(fs::exists(file_));
}

TEST_F(ImportConfinement, ForbidsNetworkProgramsAndOtherProcesses) {
  EXPECT_FALSE(Succeeds(file_, [] {
    return socket(AF_INET, SOCK_DGRAM, 0) >= 0;
  }));
  EXPECT_FALSE(Succeeds(file_, [] {
    return socket(AF_UNIX, SOCK_STREAM, 0) >= 0;
  }));
  EXPECT_FALSE(Succeeds(file_, [] {
    execl("/bin/true", "true", nullptr);
    return errno != EPERM;
  }));
  EXPECT_FALSE(Succeeds(file_, [] {
    return fork() >= 0;
  }));
  EXPECT_FALSE(Succeeds(file_, [] {
    return kill(getppid(), 0) == 0;
  }));
  EXPECT_FALSE(Succeeds(file_, [] {
    return mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1,
                0) != MAP_FAILED;
  }));
}

// A pipe tells of what it holds by a signal of the writer's choice, to a process of its choice.
TEST_F(ImportConfinement, ForbidsSignalsThroughTheAnswerPipe) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
  const int mesh = open(file_.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(mesh, 0);
  const int flags = fcntl(ends[1], F_GETFL);
  const f_owner_ex owner{F_OWNER_PID, getpid()};
  struct flock lock {};
  lock.l_type = F_RDLCK;
  const std::vector<std::pair<std::string, std::function<int()>>> attempts{
      {"F_SETOWN",
       [&] {
         return fcntl(ends[1], F_SETOWN, owner.pid);
       }},
      {"F_SETOWN_EX",
       [&] {
         return fcntl(ends[1], F_SETOWN_EX, &owner);
       }},
      {"F_SETSIG",
       [&] {
         return fcntl(ends[1], F_SETSIG, SIGURG);
       }},
      {"F_SETFL",
       [&] {
         return fcntl(ends[1], F_SETFL, flags | O_ASYNC);
       }},
      {"F_SETLEASE",
       [&] {
         return fcntl(mesh, F_SETLEASE, F_RDLCK);
       }},
      {"F_NOTIFY",
       [&] {
         return fcntl(mesh, F_NOTIFY, DN_MODIFY);
       }},
      {"F_SETLK", [&] {
         return fcntl(mesh, F_SETLK, &lock);
       }}};
  for (const auto& [command, attempt] : attempts) {
    EXPECT_TRUE(Succeeds(file_, [&] {
      return attempt() == -1 && errno == EPERM;
    })) << command;
  }
  // going through a folder asks for the flags of its descriptor
  EXPECT_TRUE(Succeeds(file_, [&] {
    return fcntl(ends[1], F_GETFL) == flags;
  }));
  EXPECT_TRUE(Succeeds(file_, [&] {
    std::error_code error;
    std::size_t entries = 0;
    for (fs::directory_iterator at(inside_.path(), error); !error && at != fs::end(at);
         at.increment(error)) {
      ++entries;
    }
    return entries == 2;
  }));
  for (const int descriptor : {ends[0], ends[1], mesh}) close(descriptor);
}

// The reading process must still be able to end by abort().
TEST_F(ImportConfinement, AllowsAbort) {
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_DUMPABLE, 0);
    ConfineToFile(file_);
    std::abort();
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
}

}  // namespace
}  // namespace tandem
