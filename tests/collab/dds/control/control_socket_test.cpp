#include "collab/dds/control/control_socket.h"

#include <cerrno>
#include <cstring>
#include <functional>

#include <gmock/gmock.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "collab/dds/control/control_folder.h"
#include "tests/support/scratch_folder.h"

// Sets out to reach a controller, or to be taken for one, as another user of the machine.

namespace tandem {
namespace {

namespace fs = std::filesystem;
using Outcome = ControlConnection::Outcome;
using ::testing::EndsWith;
using ::testing::HasSubstr;

constexpr uid_t kNobody = 65534;

/// A program of another user, which does `what` and then waits until it is told to end.
class AnotherUsersProgram {
 public:
  explicit AnotherUsersProgram(const std::function<bool()>& what) {
    int ready[2];
    int end[2];
    if (pipe(ready) != 0 || pipe(end) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      close(end[1]);
      const char done = setresuid(kNobody, kNobody, kNobody) == 0 && what() ? 'y' : 'n';
      char ignored = 0;
      static_cast<void>(!write(ready[1], &done, 1));
      static_cast<void>(!read(end[0], &ignored, 1));
      _exit(0);
    }
    close(ready[1]);
    close(end[0]);
    end_ = end[1];
    char done = 'n';
    did_ = read(ready[0], &done, 1) == 1 && done == 'y';
    close(ready[0]);
  }
  ~AnotherUsersProgram() {
    close(end_);
    waitpid(pid_, nullptr, 0);
  }
  bool did() const { return did_; }

 private:
  pid_t pid_ = -1;
  int end_ = -1;
  bool did_ = false;
};

sockaddr_un AddressOf(const fs::path& file) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, file.c_str(), sizeof address.sun_path - 1);
  return address;
}

class ControlSocket : public ::testing::Test {
 protected:
  fs::path Folder() const { return scratch_.path(); }
  ScratchFolder scratch_;
};

TEST_F(ControlSocket, CarriesPacketsWholeAndInOrder) {
  Result<ControlListener> listener = ControlListener::Open(Folder(), "desk");
  ASSERT_TRUE(listener) << listener.error().what;
  Result<ControlConnection> host = ControlConnection::To(Folder(), "desk");
  ASSERT_TRUE(host) << host.error().what;
  ControlListener::Arrival arrival = listener->Accept();
  ASSERT_TRUE(arrival.host);
  // the largest packet goes through an empty socket in one piece
  const std::vector<char> large(ControlConnection::kLargestPacket, 'x');
  EXPECT_EQ(host->Send(std::vector<char>{'a', 'b'}), Outcome::kDone);
  EXPECT_EQ(host->Send(std::vector<char>{'c'}), Outcome::kDone);
  std::vector<char> packet;
  EXPECT_EQ(arrival.host->Receive(packet), Outcome::kDone);
  EXPECT_EQ(packet, (std::vector<char>{'a', 'b'}));
  EXPECT_EQ(arrival.host->Receive(packet), Outcome::kDone);
  EXPECT_EQ(packet, (std::vector<char>{'c'}));
  EXPECT_EQ(arrival.host->Receive(packet), Outcome::kLater);
  EXPECT_EQ(host->Send(large), Outcome::kDone);
  EXPECT_EQ(arrival.host->Receive(packet), Outcome::kDone);
  EXPECT_EQ(packet, large);
  // an end that closes is seen at once, and a writer is not ended by it
  { const ControlConnection closed = *std::move(host); }
  EXPECT_EQ(arrival.host->Receive(packet), Outcome::kGone);
  EXPECT_EQ(arrival.host->Send(std::vector<char>{'d'}), Outcome::kGone);
}

TEST_F(ControlSocket, FullSocketLosesNoPacketThatItTook) {
  Result<ControlListener> listener = ControlListener::Open(Folder(), "desk");
  ASSERT_TRUE(listener);
  Result<ControlConnection> host = ControlConnection::To(Folder(), "desk");
  ASSERT_TRUE(host);
  ControlListener::Arrival arrival = listener->Accept();
  ASSERT_TRUE(arrival.host);
  int sent = 0;
  while (sent < 100'000 &&
         host->Send(std::vector<char>(1000, static_cast<char>(sent))) == Outcome::kDone) {
    ++sent;
  }
  ASSERT_GT(sent, 2);
  ASSERT_LT(sent, 100'000) << "it never fills";
  std::vector<char> packet;
  for (int i = 0; i < sent; ++i) {
    ASSERT_EQ(arrival.host->Receive(packet), Outcome::kDone);
    ASSERT_EQ(packet.front(), static_cast<char>(i));
  }
  EXPECT_EQ(arrival.host->Receive(packet), Outcome::kLater);
}

TEST_F(ControlSocket, ProgramOfAnotherUserIsRefusedEvenInAnOpenFolder) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can start another user's program";
  Result<ControlListener> listener = ControlListener::Open(Folder(), "desk");
  ASSERT_TRUE(listener);
  const fs::path file = Folder() / SocketOf("desk");
  const auto connects = [&file] {
    const sockaddr_un address = AddressOf(file);
    const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
    return connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  };
  // as it is made, the file does not let another user connect
  EXPECT_FALSE(AnotherUsersProgram(connects).did());
  // where somebody has opened it, the kernel's word on the user remains
  ASSERT_EQ(chmod(Folder().c_str(), 0755), 0);
  ASSERT_EQ(chmod(file.c_str(), 0666), 0);
  const AnotherUsersProgram connected(connects);
  ASSERT_TRUE(connected.did());
  const ControlListener::Arrival arrival = listener->Accept();
  EXPECT_TRUE(arrival.anothers);
  EXPECT_FALSE(arrival.host);
}

TEST_F(ControlSocket, HostDoesNotBelieveAnotherUsersController) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can start another user's program";
  ASSERT_EQ(chmod(Folder().c_str(), 0777), 0);
  const fs::path file = Folder() / SocketOf("desk");
  const AnotherUsersProgram imitation([&file] {
    const sockaddr_un address = AddressOf(file);
    const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
    return bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
           listen(socket, 1) == 0;
  });
  ASSERT_TRUE(imitation.did());
  const Result<ControlConnection> host = ControlConnection::To(Folder(), "desk");
  ASSERT_FALSE(host);
  EXPECT_EQ(host.error().what, "the controller 'desk' belongs to another user of this machine");
}

TEST_F(ControlSocket, ReportsThatNoControllerIsThere) {
  const Result<ControlConnection> host = ControlConnection::To(Folder(), "desk");
  ASSERT_FALSE(host);
  EXPECT_EQ(host.error().what, "no controller 'desk' on this machine");
}

// A path of a socket has a hundred bytes; names of folders are longer.
TEST_F(ControlSocket, FolderMayHaveALongPath) {
  const fs::path folder = Folder() / std::string(200, 'f');
  ASSERT_TRUE(fs::create_directory(folder));
  const Result<ControlListener> listener = ControlListener::Open(folder, "desk");
  ASSERT_TRUE(listener) << listener.error().what;
  EXPECT_TRUE(ControlConnection::To(folder, "desk"));
}

class ControlFolderTest : public ::testing::Test {
 protected:
  ControlFolderTest() {
    for (const char* name : {"XDG_RUNTIME_DIR", "XDG_CACHE_HOME", "HOME"}) {
      unsetenv(name);  // NOLINT(concurrency-mt-unsafe)
    }
  }
  static void Set(const char* name, const fs::path& value) {
    setenv(name, value.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }
  ScratchFolder scratch_;
};

TEST_F(ControlFolderTest, IsInTheRuntimeFolderForItsUserAlone) {
  Set("XDG_RUNTIME_DIR", scratch_.path());
  const Result<fs::path> folder = ControlFolder();
  ASSERT_TRUE(folder) << folder.error().what;
  EXPECT_EQ(*folder, scratch_.path() / "tandem");
  struct stat facts {};
  ASSERT_EQ(stat(folder->c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0700U);
}

// Everybody can make a folder in /tmp, and the first one keeps it.
TEST_F(ControlFolderTest, WithoutARuntimeFolderNobodyElseCanTakeIt) {
  Set("HOME", scratch_.path());
  Result<fs::path> folder = ControlFolder();
  ASSERT_TRUE(folder) << folder.error().what;
  EXPECT_EQ(*folder, scratch_.path() / ".cache" / "tandem" / "run");
  Set("XDG_CACHE_HOME", scratch_.path() / ".cache");
  folder = ControlFolder();
  ASSERT_TRUE(folder);
  EXPECT_EQ(*folder, scratch_.path() / ".cache" / "tandem" / "run");
}

TEST_F(ControlFolderTest, AnotherUsersRuntimeFolderIsPassedOver) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a folder to another user";
  const fs::path theirs = scratch_.path() / "theirs";
  const fs::path mine = scratch_.path() / "mine";
  fs::create_directories(theirs);
  fs::create_directories(mine);
  ASSERT_EQ(chown(theirs.c_str(), kNobody, kNobody), 0);
  Set("XDG_RUNTIME_DIR", theirs);
  Set("HOME", mine);
  const Result<fs::path> folder = ControlFolder();
  ASSERT_TRUE(folder) << folder.error().what;
  EXPECT_EQ(*folder, mine / ".cache" / "tandem" / "run");
  EXPECT_TRUE(fs::is_empty(theirs));
}

TEST_F(ControlFolderTest, OpenFolderIsReportedWithItsMend) {
  Set("XDG_RUNTIME_DIR", scratch_.path());
  const fs::path folder = scratch_.path() / "tandem";
  ASSERT_TRUE(fs::create_directory(folder));
  ASSERT_EQ(chmod(folder.c_str(), 0755), 0);
  const Result<fs::path> found = ControlFolder();
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().what, EndsWith("chmod 700 " + folder.string()));
  ASSERT_EQ(chmod(folder.c_str(), 0700), 0);
  EXPECT_TRUE(ControlFolder());
}

TEST_F(ControlFolderTest, WindowsControllerIsFoundByTheReadablePartOfItsName) {
  const fs::path folder = scratch_.path();
  const std::string name = UnguessableName("window-12");
  EXPECT_EQ(name.size(), std::string("window-12-").size() + 32);
  EXPECT_NE(name, UnguessableName("window-12"));
  scratch_.Write(SocketOf(name), "");
  scratch_.Write(SocketOf("desk-2"), "");
  EXPECT_EQ(FindController(folder, name), name);
  EXPECT_EQ(FindController(folder, "window-12"), name);
  EXPECT_EQ(FindController(folder, "window-1"), std::nullopt);
  EXPECT_EQ(FindController(folder, "desk"), std::nullopt) << "desk-2 is another name";
  scratch_.Write(SocketOf(UnguessableName("window-12")), "");
  EXPECT_EQ(FindController(folder, "window-12"), std::nullopt) << "two fit";
}

}  // namespace
}  // namespace tandem
